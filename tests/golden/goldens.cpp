#include "tests/golden/goldens.h"

#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include "stereo/image/codec.h"
#include "tests/support/image_reader.h"
#include "tests/support/test_place.h"

namespace farshade {
namespace {

std::filesystem::path golden_path(const std::string& scene, const std::string& what, Side side) {
  return test_root() / "tests/golden/images" /
         ("lavapipe_embree_" + scene + "_" + what + "_" + name_of(side) + ".png");
}

}  // namespace

PerEye<Image<Rgb8>> goldens(const std::string& scene, const std::string& what) {
  PerEye<Image<Rgb8>> images;
  for (const Side side : kSides) {
    auto image = read_png(golden_path(scene, what, side));
    if (!image) throw std::runtime_error(image.error().what);
    images[index_of(side)] = std::move(*image);
  }
  return images;
}

testing::AssertionResult agrees_with(const Image<Rgb8>& picture, const Image<Rgb8>& golden) {
  const Distance d = distance(picture, golden);
  return (agrees(d) ? testing::AssertionSuccess() : testing::AssertionFailure())
         << d.psnr_db << " dB, " << d.differing_share * 100 << " % of pixels differ";
}

void expect_golden(const std::string& scene, const std::string& what, const PerEye<Image<Rgb8>>& pictures) {
  if (std::getenv("FARSHADE_UPDATE_GOLDENS"))
    for (const Side side : kSides) {
      const auto written = write_png(golden_path(scene, what, side), pictures[index_of(side)]);
      ASSERT_TRUE(written) << written.error().what;
    }
  const PerEye<Image<Rgb8>> golden = goldens(scene, what);
  for (const Side side : kSides) {
    ASSERT_EQ(pictures[index_of(side)].size, golden[index_of(side)].size);
    EXPECT_TRUE(agrees_with(pictures[index_of(side)], golden[index_of(side)]))
        << what << ", " << name_of(side);
  }
}

void expect_refused(const PerEye<Image<Rgb8>>& pictures, const PerEye<Image<Rgb8>>& golden) {
  for (const Side side : kSides)
    EXPECT_FALSE(agrees_with(pictures[index_of(side)], golden[index_of(side)])) << name_of(side);
}

}  // namespace farshade
