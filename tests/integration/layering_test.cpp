#include "tests/integration/layering.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/integration/declared_libraries.h"

namespace farshade {
namespace {

/// Where each library may be named, and in how many files.
std::vector<Library> libraries() {
  constexpr std::size_t any = SIZE_MAX;
  return {{"asio", "stereo/net", 3},
          {"lz4", "stereo/codec", 1},
          {"embree", "stereo", 2},
          {"meshoptimizer", "stereo", 5},
          {"draco", "stereo/gltf", 1},
          {"tiny_gltf", "stereo/gltf", 2},
          {"png.h", "stereo/image", 1},
          {"avahi", "stereo/announce", 3},
          {"zlib.h", "vr_client/record", 1},
          {"webp", "stereo/image", 1},
          {"jpeglib.h", "stereo/image", 1},
          {"vulkan", "stereo/gpu", any},
          {"libavcodec", "stereo/video", 2},
          {"libavutil", "stereo/video", 2},
          {"libswscale", "stereo/video", 1},
          {"GLFW", "vr_client/preview", 1},
          {"imgui", "vr_client", any},  // its font also labels pictures of reports
          {"backends/imgui", "vr_client/preview", any},
          {"openxr", "vr_client/openxr", any}};
}

/// The folders that both programs share: base <- math <- frame <- messages, then sealing <- net and codec <-
/// answers beside each other, scene <- gltf, raster <- shadow_maps <- edge_rays <- reproject <- draw, the
/// others beside them.
std::vector<Layer> shared_layers() {
  return {{"stereo/base", {}},
          {"stereo/math", {"stereo/base"}},
          {"stereo/frame", {"stereo/math"}},
          {"stereo/messages", {"stereo/frame"}},
          {"stereo/codec", {"stereo/messages"}},
          {"stereo/sealing", {"stereo/messages"}},
          {"stereo/net", {"stereo/sealing"}},
          {"stereo/answers", {"stereo/codec"}},
          {"stereo/pair", {"stereo/net"}},
          {"stereo/announce", {"stereo/net"}},
          {"stereo/fetch", {"stereo/scene", "stereo/messages"}},
          {"stereo/image", {"stereo/base"}},
          {"stereo/metrics", {"stereo/frame", "stereo/image"}},
          {"stereo/head", {"stereo/frame"}},
          {"stereo/scene", {"stereo/image", "stereo/frame"}},
          {"stereo/gltf", {"stereo/scene"}},
          {"stereo/options", {"stereo/scene"}},
          {"stereo/plan", {"stereo/scene", "stereo/frame"}},
          {"stereo/tracer", {"stereo/plan"}},
          {"stereo/placement", {"stereo/head", "stereo/tracer"}},
          {"stereo/exposure", {"stereo/placement"}},
          {"stereo/gpu", {"stereo/frame", "stereo/image"}},
          {"stereo/lod", {"stereo/scene", "stereo/frame"}},
          {"stereo/raster", {"stereo/plan", "stereo/gpu", "stereo/lod", "shaders"}},
          {"stereo/shadow_maps", {"stereo/raster"}},
          {"stereo/edge_rays", {"stereo/shadow_maps"}},
          {"stereo/reproject", {"stereo/edge_rays"}},
          {"stereo/draw", {"stereo/reproject"}},
          {"stereo/embed", {"stereo/draw"}},
          {"stereo/video", {"stereo/frame", "stereo/image"}},
          {"stereo/doctor", {"stereo/net", "stereo/scene"}},
          {"stereo/about", {}},
          {"shaders", {}}};
}

/// The folders of both programs. Neither program includes the other.
std::vector<Layer> program_layers() {
  return {{"rt_server/admission", {"stereo/net"}},
          {"rt_server/scheduling", {"stereo/sealing"}},
          {"rt_server/log", {"stereo/net"}},
          {"rt_server/sessions", {"rt_server/admission", "rt_server/scheduling", "rt_server/log"}},
          {"rt_server/work", {"rt_server/sessions", "stereo/answers"}},
          {"rt_server/answers", {"rt_server/work", "stereo/draw", "stereo/tracer", "stereo/video"}},
          {"rt_server/commands",
           {"stereo/announce", "stereo/doctor", "stereo/exposure", "stereo/pair", "stereo/gltf",
            "stereo/options"}},
          {"rt_server/fetch", {"stereo/fetch", "stereo/net"}},
          {"rt_server/keys", {"rt_server/work", "rt_server/fetch"}},
          {"rt_server",
           {"rt_server/answers", "rt_server/commands", "rt_server/keys", "stereo/about", "stereo/exposure"}},
          {"stereo/requests", {"stereo/head"}},
          {"stereo/link", {"stereo/net", "stereo/answers"}},
          {"stereo/partial_request", {"stereo/draw", "stereo/link", "stereo/requests"}},
          {"vr_client/runtime", {"stereo/head", "stereo/gpu"}},
          {"vr_client/openxr", {"vr_client/runtime", "stereo/gpu"}},
          {"vr_client/fetch", {"stereo/fetch", "stereo/net"}},
          {"vr_client/pair", {"stereo/pair"}},
          {"vr_client/doctor",
           {"stereo/announce", "stereo/doctor", "stereo/gpu", "vr_client/fetch", "stereo/gltf",
            "stereo/options"}},
          {"vr_client/frame",
           {"stereo/requests", "stereo/link", "vr_client/runtime", "stereo/draw", "stereo/tracer"}},
          {"vr_client/modes", {"vr_client/frame", "stereo/partial_request", "stereo/video"}},
          {"vr_client/report", {"vr_client/frame", "stereo/metrics", "stereo/options"}},
          {"vr_client/record", {"vr_client/frame"}},
          {"vr_client/preview", {"vr_client/report", "vr_client/record"}},
          {"vr_client",
           {"vr_client/modes", "vr_client/preview", "vr_client/openxr", "vr_client/doctor", "vr_client/pair",
            "stereo/exposure", "stereo/about"}}};
}

const Layering& layering() {
  static const Layering layering = [] {
    Layering result{.layers = shared_layers(), .libraries = libraries(), .unrestricted = "tests"};
    std::ranges::move(program_layers(), std::back_inserter(result.layers));
    return result;
  }();
  return layering;
}

TEST(Layering, HoldsInThisTree) {
  const auto tree = read_tree(FARSHADE_SOURCE, layering());
  EXPECT_GT(tree.size(), 50u);
  for (const std::string& fault : faults(layering(), tree)) ADD_FAILURE() << fault;
}

TEST(Layering, EveryProgramFolderDeclaresTheLibrariesThatItIncludes) {
  const auto libraries = read_libraries(FARSHADE_SOURCE, {"stereo", "rt_server", "vr_client"});
  EXPECT_GT(libraries.size(), 25u);
  const auto tree = read_tree(FARSHADE_SOURCE, layering());
  for (const std::string& fault : undeclared(libraries, tree, {"rt_server", "vr_client"}))
    ADD_FAILURE() << fault;
}

// The checks below run the checker on trees that do not exist.

using Tree = std::vector<SourceFile>;

std::string only_fault(const Tree& tree) {
  const auto found = faults(layering(), tree);
  EXPECT_EQ(found.size(), 1u);
  return found.empty() ? "" : found.front();
}

TEST(LayeringChecker, ReadsBothKindsOfInclude) {
  const auto tree = read_tree(FARSHADE_SOURCE, layering());
  const auto checker = std::ranges::find(tree, "tests/integration/layering.cpp", &SourceFile::path);
  ASSERT_NE(checker, tree.end());
  EXPECT_EQ(checker->ours, (std::vector<std::string>{"tests/integration/layering.h"}));
  EXPECT_EQ(checker->theirs.front(), "algorithm");
  EXPECT_EQ(checker->theirs.size(), 5u);
}

TEST(LayeringChecker, AcceptsIndirectPermission) {
  EXPECT_TRUE(faults(layering(),
                     {{"stereo/net/a.cpp", {"stereo/base/b.h", "stereo/net/a.h"}, {"asio/ip/udp.hpp"}},
                      {"vr_client/a.cpp", {"stereo/tracer/b.h", "shaders/c.h", "vr_client/modes/d.h"}, {}},
                      {"tests/unit/a.cpp", {"tests/b.h", "rt_server/c.h"}, {"asio.hpp", "png.h"}}})
                  .empty());
}

TEST(LayeringChecker, RefusesIncludesUpAndAcross) {
  EXPECT_EQ(only_fault({{"stereo/math/a.h", {"stereo/frame/b.h"}, {}}}),
            "stereo/math/a.h includes \"stereo/frame/b.h\", which stereo/math may not include");
  EXPECT_NE(only_fault({{"stereo/image/a.h", {"stereo/frame/b.h"}, {}}}), "");
  EXPECT_NE(only_fault({{"stereo/gpu/a.h", {"vr_client/b.h"}, {}}}), "");
  EXPECT_NE(only_fault({{"rt_server/a.h", {"vr_client/b.h"}, {}}}), "");
  EXPECT_NE(only_fault({{"vr_client/a.h", {"rt_server/b.h"}, {}}}), "");
  EXPECT_NE(only_fault({{"vr_client/a.h", {"tests/b.h"}, {}}}), "");
}

TEST(LayeringChecker, RefusesPathsThatAreNotFromTheRoot) {
  EXPECT_NE(only_fault({{"stereo/math/a.cpp", {"a.h"}, {}}}).find("no path from the root"),
            std::string::npos);
  EXPECT_EQ(only_fault({{"stereo/attic/a.cpp", {}, {}}}), "stereo/attic/a.cpp is in no layer");
  EXPECT_EQ(only_fault({{"stereo/mathematics/a.cpp", {}, {}}}), "stereo/mathematics/a.cpp is in no layer");
  EXPECT_EQ(only_fault({{"vr_client/attic/a.cpp", {}, {}}}), "vr_client/attic/a.cpp is in no layer");
}

TEST(LayeringChecker, RefusesLibrariesElsewhereOrTwice) {
  EXPECT_EQ(only_fault({{"rt_server/a.cpp", {}, {"asio/ip/udp.hpp"}}}),
            "rt_server/a.cpp names <asio>, which belongs to stereo/net");
  EXPECT_EQ(only_fault({{"stereo/codec/a.cpp", {}, {"lz4.h"}}, {"stereo/codec/b.cpp", {}, {"lz4.h"}}}),
            "<lz4> is named by more than 1: stereo/codec/a.cpp stereo/codec/b.cpp");
}

TEST(LayeringChecker, RefusesCycles) {
  EXPECT_EQ(only_fault(
                {{"stereo/math/a.h", {"stereo/math/b.h"}, {}}, {"stereo/math/b.h", {"stereo/math/a.h"}, {}}}),
            "stereo/math/b.h closes a cycle with stereo/math/a.h");
  const Layering circular{
      .layers = {{"a", {"b"}}, {"b", {"c"}}, {"c", {"a"}}}, .libraries = {}, .unrestricted = "tests"};
  EXPECT_EQ(faults(circular, {}).size(), 3u);
}

/// These are the cycles that the programs once had.
TEST(LayeringChecker, RefusesTheCyclesOfTheProgramsWhenTheyArePutBack) {
  struct Cycle {
    std::string_view below, above;
  };
  for (const Cycle& cycle :
       {Cycle{"vr_client/frame", "vr_client/modes"}, Cycle{"vr_client/frame", "vr_client/record"},
        Cycle{"vr_client/frame", "vr_client/report"}, Cycle{"vr_client/frame", "vr_client/preview"},
        Cycle{"rt_server/work", "rt_server/answers"}, Cycle{"rt_server/sessions", "rt_server/work"},
        Cycle{"stereo/raster", "stereo/reproject"}, Cycle{"stereo/scene", "stereo/gltf"}}) {
    SCOPED_TRACE(cycle.below);
    // In this tree, as one more include of a file that exists.
    auto tree = read_tree(FARSHADE_SOURCE, layering());
    const auto file = std::ranges::find_if(tree, [&](const SourceFile& f) {
      return f.path.starts_with(std::string(cycle.below) + "/") && f.path.ends_with(".cpp");
    });
    const auto header = std::ranges::find_if(tree, [&](const SourceFile& f) {
      return f.path.starts_with(std::string(cycle.above) + "/") && f.path.ends_with(".h");
    });
    ASSERT_TRUE(file != tree.end() && header != tree.end());
    file->ours.push_back(header->path);
    EXPECT_EQ(only_fault(tree), file->path + " includes \"" + header->path + "\", which " +
                                    std::string(cycle.below) + " may not include");
    // Permission alone does not help: the layers then form a cycle.
    Layering permissive = layering();
    std::ranges::find(permissive.layers, cycle.below, &Layer::folder)->sees.push_back(cycle.above);
    const auto found = faults(permissive, tree);
    EXPECT_NE(std::ranges::find(found, std::string(cycle.below) + " may include itself through a cycle"),
              found.end());
  }
}

/// Two libraries below a program, in the form of its CMakeLists.txt.
std::vector<DeclaredLibrary> sample_libraries(const std::string& depends) {
  auto libraries = parse_libraries(
      "# farshade_library(none)\nfarshade_library(low\n  HEADERS l.h SOURCES l.cpp)\n", "vr_client/low");
  const auto high = parse_libraries("farshade_library(high HEADERS h.h SOURCES h.cpp\n  " + depends + ")",
                                    "vr_client/high");
  libraries.insert(libraries.end(), high.begin(), high.end());
  return libraries;
}

TEST(DeclaredLibraries, FindsWhatIsIncludedWithoutBeingDeclared) {
  const Tree none{{"vr_client/low/l.h", {}, {}},
                  {"vr_client/low/l.cpp", {"vr_client/low/l.h"}, {}},
                  {"vr_client/high/h.h", {}, {}},
                  {"vr_client/high/h.cpp", {}, {}}};
  Tree in_source = none, in_header = none;
  in_source[3].ours = {"vr_client/low/l.h"};
  in_header[2].ours = {"vr_client/low/l.h"};
  const auto found = [](const std::string& depends, const Tree& tree) {
    return undeclared(sample_libraries(depends), tree, {"vr_client"});
  };
  EXPECT_TRUE(found("", none).empty());
  EXPECT_TRUE(found("PRIVATE_DEPENDS low", in_source).empty());
  EXPECT_TRUE(found("DEPENDS low", in_source).empty());
  EXPECT_TRUE(found("DEPENDS low", in_header).empty());
  EXPECT_EQ(found("", in_source),
            std::vector<std::string>{
                "vr_client/high/h.cpp includes vr_client/low/l.h of low, which high does not declare"});
  EXPECT_EQ(found("PRIVATE_DEPENDS low", in_header).size(), 1u);
  EXPECT_EQ(found("DEPENDS low", none),
            std::vector<std::string>{"high declares low and includes none of its headers"});
  Tree more = none;
  more.push_back({"vr_client/high/new.cpp", {}, {}});
  EXPECT_EQ(found("", more), std::vector<std::string>{"vr_client/high/new.cpp is in no library"});
}

TEST(DeclaredLibraries, ReadsPrograms) {
  const auto programs = parse_libraries(
      "add_executable(rt main.cpp)\ntarget_link_libraries(rt PRIVATE a\n  b)\ntarget_link_libraries(x PUBLIC "
      "c)",
      "rt_server");
  ASSERT_EQ(programs.size(), 1u);
  EXPECT_EQ(programs[0].files, std::vector<std::string>{"rt_server/main.cpp"});
  EXPECT_EQ(programs[0].private_depends, (std::vector<std::string>{"a", "b"}));
}

}  // namespace
}  // namespace farshade
