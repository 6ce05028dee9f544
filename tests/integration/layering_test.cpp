#include "tests/integration/layering.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace farshade {
namespace {

/// The house as it is meant to stand: base <- math <- frame <- wire <- net, the others beside them, both
/// programs on top, neither seeing the other.
const House& house() {
  constexpr std::size_t any = SIZE_MAX;
  static const House house{
      .rooms = {{"stereo/base", {}},
                {"stereo/math", {"stereo/base"}},
                {"stereo/frame", {"stereo/math"}},
                {"stereo/wire", {"stereo/frame"}},
                {"stereo/net", {"stereo/wire"}},
                {"stereo/image", {"stereo/base"}},
                {"stereo/head", {"stereo/frame"}},
                {"stereo/scene", {"stereo/image", "stereo/frame"}},
                {"stereo/plan", {"stereo/scene", "stereo/frame"}},
                {"stereo/tracer", {"stereo/plan"}},
                {"stereo/gpu", {"stereo/frame", "stereo/image"}},
                {"stereo/draw", {"stereo/gpu", "stereo/plan", "shaders"}},
                {"stereo/video", {"stereo/frame", "stereo/image"}},
                {"stereo/doctor", {"stereo/net", "stereo/scene"}},
                {"shaders", {}},
                {"rt_server/core", {"stereo/net", "stereo/tracer"}},
                {"rt_server/answers", {"rt_server/core", "stereo/draw", "stereo/video"}},
                {"rt_server/keys", {"stereo/wire"}},
                {"rt_server/doctor", {"stereo/doctor", "stereo/gpu", "stereo/video"}},
                {"rt_server", {"rt_server/answers", "rt_server/keys", "rt_server/doctor"}},
                {"vr_client/ask", {"stereo/head"}},
                {"vr_client/link", {"stereo/net"}},
                {"vr_client/runtime", {"stereo/head"}},
                {"vr_client/doctor", {"stereo/doctor", "stereo/gpu", "stereo/head", "stereo/video"}},
                {"vr_client/frame",
                 {"vr_client/ask", "vr_client/link", "vr_client/runtime", "stereo/draw", "stereo/tracer"}},
                {"vr_client/modes", {"vr_client/frame", "stereo/video"}},
                {"vr_client/report", {"vr_client/frame"}},
                {"vr_client/record", {"vr_client/frame"}},
                {"vr_client/preview", {"vr_client/report", "vr_client/record"}},
                {"vr_client", {"vr_client/modes", "vr_client/preview", "vr_client/doctor"}}},
      .libraries = {{"asio", "stereo/net", 1},
                    {"lz4", "stereo/wire", 1},
                    {"embree", "stereo/tracer", 1},
                    {"png.h", "stereo/image", 1},
                    {"jpeglib.h", "stereo/image", 1},
                    {"vulkan", "stereo/gpu", any},
                    {"libavcodec", "stereo/video", 2},
                    {"libavutil", "stereo/video", 2},
                    {"libswscale", "stereo/video", 1},
                    {"GLFW", "vr_client/preview", 1},
                    {"imgui", "vr_client/preview", any},
                    {"backends/imgui", "vr_client/preview", any},
                    {"openxr", "vr_client", 1}},
      .guests = "tests"};
  return house;
}

TEST(Layering, HoldsInThisTree) {
  const auto tree = read_tree(FARSHADE_SOURCE, house());
  EXPECT_GT(tree.size(), 50u);
  for (const std::string& fault : faults(house(), tree)) ADD_FAILURE() << fault;
}

// The checker itself, on trees that do not exist.

using Tree = std::vector<SourceFile>;

std::string only_fault(const Tree& tree) {
  const auto found = faults(house(), tree);
  EXPECT_EQ(found.size(), 1u);
  return found.empty() ? "" : found.front();
}

TEST(LayeringChecker, ReadsBothKindsOfInclude) {
  const auto tree = read_tree(FARSHADE_SOURCE, house());
  const auto checker = std::ranges::find(tree, "tests/integration/layering.cpp", &SourceFile::path);
  ASSERT_NE(checker, tree.end());
  EXPECT_EQ(checker->ours, (std::vector<std::string>{"tests/integration/layering.h"}));
  EXPECT_EQ(checker->theirs.front(), "algorithm");
  EXPECT_EQ(checker->theirs.size(), 5u);
}

TEST(LayeringChecker, AcceptsArrowsAtAnyRemove) {
  EXPECT_TRUE(
      faults(house(), {{"stereo/net/a.cpp", {"stereo/base/b.h", "stereo/net/a.h"}, {"asio/ip/udp.hpp"}},
                       {"vr_client/a.cpp", {"stereo/tracer/b.h", "shaders/c.h", "vr_client/x/d.h"}, {}},
                       {"tests/unit/a.cpp", {"tests/b.h", "rt_server/c.h"}, {"asio.hpp", "png.h"}}})
          .empty());
}

TEST(LayeringChecker, RefusesArrowsUpAndAcross) {
  EXPECT_EQ(only_fault({{"stereo/math/a.h", {"stereo/frame/b.h"}, {}}}),
            "stereo/math/a.h includes \"stereo/frame/b.h\", which stereo/math does not see");
  EXPECT_NE(only_fault({{"stereo/image/a.h", {"stereo/frame/b.h"}, {}}}), "");
  EXPECT_NE(only_fault({{"stereo/gpu/a.h", {"vr_client/b.h"}, {}}}), "");
  EXPECT_NE(only_fault({{"rt_server/a.h", {"vr_client/b.h"}, {}}}), "");
  EXPECT_NE(only_fault({{"vr_client/a.h", {"rt_server/b.h"}, {}}}), "");
  EXPECT_NE(only_fault({{"vr_client/a.h", {"tests/b.h"}, {}}}), "");
}

TEST(LayeringChecker, RefusesPathsThatAreNotFromTheRoot) {
  EXPECT_NE(only_fault({{"stereo/math/a.cpp", {"a.h"}, {}}}).find("no path from the root"),
            std::string::npos);
  EXPECT_EQ(only_fault({{"stereo/attic/a.cpp", {}, {}}}), "stereo/attic/a.cpp is in no room");
  EXPECT_EQ(only_fault({{"stereo/mathematics/a.cpp", {}, {}}}), "stereo/mathematics/a.cpp is in no room");
}

TEST(LayeringChecker, RefusesLibrariesElsewhereOrTwice) {
  EXPECT_EQ(only_fault({{"rt_server/a.cpp", {}, {"asio/ip/udp.hpp"}}}),
            "rt_server/a.cpp names <asio>, which belongs to stereo/net");
  EXPECT_EQ(
      only_fault({{"stereo/net/a.cpp", {}, {"asio/ip/udp.hpp"}}, {"stereo/net/b.cpp", {}, {"asio.hpp"}}}),
      "<asio> is named by more than 1: stereo/net/a.cpp stereo/net/b.cpp");
}

TEST(LayeringChecker, RefusesCircles) {
  EXPECT_EQ(only_fault(
                {{"stereo/math/a.h", {"stereo/math/b.h"}, {}}, {"stereo/math/b.h", {"stereo/math/a.h"}, {}}}),
            "stereo/math/b.h closes a circle with stereo/math/a.h");
  const House circular{
      .rooms = {{"a", {"b"}}, {"b", {"c"}}, {"c", {"a"}}}, .libraries = {}, .guests = "tests"};
  EXPECT_EQ(faults(circular, {}).size(), 3u);
}

}  // namespace
}  // namespace farshade
