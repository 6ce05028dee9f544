/// Compares pictures of both eyes with committed goldens, and expects that the comparison fails for pictures
/// with deliberate faults. README.md says how to regenerate the goldens.
#include <numbers>

#include "stereo/image/difference.h"
#include "tests/golden/goldens.h"
#include "tests/golden/test_rig.h"

namespace farshade {
namespace {

struct GoldenScene {
  const char* name;
  const char* file;
  std::uint32_t side_px;
  double least_shown_db;              ///< PSNR of the picture with stale shadows against the reference
  std::vector<std::uint32_t> lights;  ///< switching one of them off changes both eyes visibly
  std::optional<Rigid<Stage, Head>> head = std::nullopt;  ///< empty: at the scene's camera
};

std::ostream& operator<<(std::ostream& out, const GoldenScene& scene) {
  return out << scene.name;
}

Image<Rgb8> mirrored(const Image<Rgb8>& image) {
  Image<Rgb8> result(image.size);
  for (std::uint32_t y = 0; y < image.size.height; ++y)
    for (std::uint32_t x = 0; x < image.size.width; ++x)
      result.at(x, y) = image.at(image.size.width - 1 - x, y);
  return result;
}

/// The image shifted right and down, with repeated border pixels.
Image<Rgb8> shifted(const Image<Rgb8>& image, std::uint32_t right, std::uint32_t down) {
  Image<Rgb8> result(image.size);
  for (std::uint32_t y = 0; y < image.size.height; ++y)
    for (std::uint32_t x = 0; x < image.size.width; ++x)
      result.at(x, y) = image.at(x - std::min(x, right), y - std::min(y, down));
  return result;
}

/// A picture at the scene's camera. Its shadows were traced 3 degrees and 2 cm away or, for the reference, at
/// it.
class Golden : public OnLavapipe, public testing::WithParamInterface<GoldenScene> {
 protected:
  TestRig rig_{device_, bundled(GetParam().file), GetParam().side_px};
  Rigid<Stage, Head> head_ = GetParam().head.value_or(rig_.head());
  StereoView now_ = rig_.eyes(head_);
  Mask stale_ = rig_.ask(kTraced, rig_.eyes(moved(head_, 3 * std::numbers::pi / 180, {0.02, 0, 0})));
};

TEST_P(Golden, ShownAndReferenceAreTheirGoldens) {
  const PerEye<Image<Rgb8>> shown = rig_.show(now_, {stale_.traced_mask()}).pictures,
                            reference = rig_.show_reference(now_);
  expect_golden(GetParam().name, "shown", shown);
  expect_golden(GetParam().name, "reference", reference);
  for (const Side side : kSides)
    EXPECT_GE(psnr_db(shown[index_of(side)], reference[index_of(side)]), GetParam().least_shown_db);
}

TEST_P(Golden, RefusesADroppedLight) {
  const Mask truth = rig_.trace(kNow, now_);
  for (const std::uint32_t light : GetParam().lights) {
    SCOPED_TRACE("without light " + std::to_string(light));
    Mask without = truth;
    for (EyeMask& bits : without.bits)
      for (std::uint32_t y = 0; y < bits.size().height; ++y)
        for (std::uint32_t x = 0; x < bits.size().width; ++x)
          bits.set_word(x, y, 0, bits.word(x, y) & ~(1u << light));
    expect_refused(rig_.show(now_, {without.traced_mask()}, {.lookup = Lookup::Direct}).pictures,
                   goldens(GetParam().name, "reference"));
  }
}

TEST_P(Golden, RefusesSwappedEyes) {
  const PerEye<Image<Rgb8>> shown = rig_.show(now_, {stale_.traced_mask()}).pictures;
  expect_refused({shown[1], shown[0]}, goldens(GetParam().name, "shown"));
}

TEST_P(Golden, RefusesMasksOfSwappedEyes) {
  Mask swapped = rig_.trace(kNow, now_);
  std::swap(swapped.bits[0], swapped.bits[1]);
  expect_refused(rig_.show(now_, {swapped.traced_mask()}, {.lookup = Lookup::Direct}).pictures,
                 goldens(GetParam().name, "reference"));
}

TEST_P(Golden, RefusesAnIgnoredPoseDelta) {
  const PerEye<Image<Rgb8>> ignored =
      rig_.show(now_, {stale_.traced_mask()}, {.lookup = Lookup::Direct}).pictures;
  expect_refused(ignored, goldens(GetParam().name, "shown"));
  expect_refused(ignored, goldens(GetParam().name, "reference"));
}

TEST_P(Golden, RefusesMirroredAndShiftedPictures) {
  const PerEye<Image<Rgb8>> golden = goldens(GetParam().name, "reference");
  const auto of_both = [&](const auto& change) {
    return PerEye<Image<Rgb8>>{change(golden[0]), change(golden[1])};
  };
  expect_refused(of_both(mirrored), golden);
  expect_refused(of_both([](const auto& image) { return shifted(image, 1, 0); }), golden);
  expect_refused(of_both([](const auto& image) { return shifted(image, 0, 1); }), golden);
}

INSTANTIATE_TEST_SUITE_P(
    , Golden,
    testing::Values(
        GoldenScene{"box_over_plane", "box_over_plane.gltf", 128, 34, {0, 1}},
        GoldenScene{"room", "room.glb", 192, 20, {0, 1, 2}},
        GoldenScene{"plant", "room.glb", 160, 22, {1, 2}, head_looking({1.5, 1.5, -0.5}, {2.5, 1.0, -1.95})}),
    [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace farshade
