/// Compares each eye's picture, shaded with reprojected masks, with the same picture with all shadows traced,
/// for a fixed list of pose deltas and ages. The comparison must fail for deliberate faults. The rows are
/// measured values; a picture may be worse by kMargin. README.md says how to repeat the measurement and where
/// the pictures are.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "stereo/gltf/gltf.h"
#include "stereo/image/codec.h"
#include "stereo/image/difference.h"
#include "stereo/metrics/flip.h"
#include "stereo/metrics/pixels_per_degree.h"
#include "stereo/metrics/ssim.h"
#include "tests/golden/pose_cases.h"
#include "tests/golden/pose_delta_rows.h"
#include "tests/golden/reproject_reference.h"
#include "tests/golden/test_rig.h"
#include "tests/support/heat_map.h"
#include "tests/support/test_place.h"
#include "vr_client/report/measure.h"

namespace farshade {
namespace {

constexpr std::uint32_t kDeltaSide_px = 192;
constexpr Time kNow{std::chrono::seconds(1)};  ///< time of the scene's animation

/// Allows for another compiler's rounding at edges; smaller than the effect of any fault below.
constexpr Judged kMargin{0.5, 0.004, 0.003};

std::string to_text(const Judged& judged) {
  return fmt::format("{{{:.2f}, {:.4f}, {:.4f}}}", judged.psnr_db, judged.ssim, judged.flip);
}

Scene scene_named(const std::string& name) {
  if (name == "box_over_plane") return bundled("box_over_plane.gltf");
  if (name == "room") return bundled("room.glb");
#ifdef FARSHADE_SHARED_SCENES
  auto scene = load_scene(shared_scene(name + ".glb"));
  if (scene) return std::move(*scene);
#endif
  throw std::runtime_error("no scene " + name);
}

Judged judge(const Image<Rgb8>& picture, const Image<Rgb8>& reference, const View& view) {
  return {psnr_db(picture, reference), ssim(picture, reference),
          mean(flip(reference, picture, pixels_per_degree(view)))};
}

testing::AssertionResult is_as_good(const Judged& now, const Judged& measured) {
  const bool good = now.psnr_db >= measured.psnr_db - kMargin.psnr_db &&
                    now.ssim >= measured.ssim - kMargin.ssim && now.flip <= measured.flip + kMargin.flip;
  return (good ? testing::AssertionSuccess() : testing::AssertionFailure())
         << "PSNR, SSIM, FLIP are " << to_text(now) << ", were " << to_text(measured);
}

/// A row for each eye: the shown picture, the reference, and the differences that a viewer would see.
void write_artefact(const std::string& name, const PerEye<Image<Rgb8>>& shown,
                    const PerEye<Image<Rgb8>>& reference, const StereoView& views) {
  Image<Rgb8> sheet({3 * kDeltaSide_px, kEyes * kDeltaSide_px});
  for (std::uint32_t eye = 0; eye < kEyes; ++eye) {
    const Image<Rgb8> map = heat_map(flip(reference[eye], shown[eye], pixels_per_degree(views[eye])));
    const Image<Rgb8>* const columns[]{&shown[eye], &reference[eye], &map};
    for (std::uint32_t x = 0; x < sheet.size.width; ++x)
      for (std::uint32_t y = 0; y < kDeltaSide_px; ++y)
        sheet.at(x, eye * kDeltaSide_px + y) = columns[x / kDeltaSide_px]->at(x % kDeltaSide_px, y);
  }
  const std::filesystem::path folder = test_output() / "pose_delta";
  std::filesystem::create_directories(folder);
  const auto written = write_png(folder / (name + ".png"), sheet);
  EXPECT_TRUE(written) << written.error().what;
}

class PoseDelta : public OnLavapipe, public testing::WithParamInterface<Row> {};

TEST_P(PoseDelta, ShowsWhatAFullTraceWould) {
  const auto& [scene, pose, ages] = GetParam();
  TestRig rig(device_, scene_named(scene), kDeltaSide_px);
  const PoseViews views = views_of(pose_case(pose), rig.head(), kDeltaSide_px);
  rig.set_time(kNow);
  const PerEye<Image<Rgb8>> reference = rig.show_reference(views.shown);
  std::string measured;
  for (const auto& [age_ms, expected] : ages) {
    rig.set_time(kNow - std::chrono::milliseconds(age_ms));
    const Mask traced = rig.ask(FrameId{static_cast<std::uint32_t>(age_ms + 1)}, views.traced);
    rig.set_time(kNow);
    const PerEye<Image<Rgb8>> shown = rig.show(views.shown, {traced.traced_mask()}).pictures;
    PerEye<Judged> eyes;
    for (const Side side : kSides) {
      const std::size_t eye = index_of(side);
      eyes[eye] = judge(shown[eye], reference[eye], views.shown[eye]);
      EXPECT_TRUE(is_as_good(eyes[eye], expected[eye])) << age_ms << " ms old, " << name_of(side);
    }
    measured += fmt::format("{}{{{}, {{{{{}, {}}}}}}}", measured.empty() ? "" : ", ", age_ms,
                            to_text(eyes[0]), to_text(eyes[1]));
    write_artefact(fmt::format("{}_{}_{}ms", scene, pose, age_ms), shown, reference, views.shown);
  }
  RecordProperty("measured", measured);
  if (std::getenv("FARSHADE_PRINT_ROWS")) fmt::print("{{\"{}\", \"{}\", {{{}}}}},\n", scene, pose, measured);
}

const auto kNameOfRow = [](const auto& tested) {
  return std::string(tested.param.scene) + "_" + tested.param.pose;
};
INSTANTIATE_TEST_SUITE_P(, PoseDelta, testing::ValuesIn(bundled_rows().begin(), bundled_rows().end()),
                         kNameOfRow);
#ifdef FARSHADE_SHARED_SCENES
INSTANTIATE_TEST_SUITE_P(Shared, PoseDelta, testing::ValuesIn(shared_rows().begin(), shared_rows().end()),
                         kNameOfRow);
#endif

/// A correct set-up, into which each test puts one fault.
class PoseDeltaFault : public OnLavapipe, public testing::WithParamInterface<const char*> {
 protected:
  /// The mask for `pose`, and the views in which it is shown.
  Mask ask(const char* pose) {
    pose_ = pose;
    views_ = views_of(pose_case(pose), rig_.head(), kDeltaSide_px);
    reference_ = rig_.show_reference(views_.shown);
    return rig_.ask(FrameId{1}, views_.traced);
  }

  /// Expects that neither eye's picture is as good as the picture that was measured without the fault.
  void expect_refused(const PerEye<Image<Rgb8>>& shown, const char* fault) const {
    for (const Side side : kSides) {
      const std::size_t eye = index_of(side);
      EXPECT_FALSE(is_as_good(judged(shown, eye), measured()[eye])) << pose_ << ", " << name_of(side);
    }
    write_artefact(fmt::format("{}_{}_{}", GetParam(), pose_, fault), shown, reference_, views_.shown);
  }

  [[nodiscard]] Judged judged(const PerEye<Image<Rgb8>>& shown, std::size_t eye) const {
    return judge(shown[eye], reference_[eye], views_.shown[eye]);
  }

  /// Shadows are read at the same pixels at which they are shown.
  PerEye<Image<Rgb8>> show_as_they_are(Mask mask) {
    mask.views = views_.shown;
    return rig_.show(views_.shown, {mask.traced_mask()}, {.lookup = Lookup::Direct}).pictures;
  }

  TestRig rig_{device_, scene_named(GetParam()), kDeltaSide_px};
  PoseViews views_;

 private:
  [[nodiscard]] PerEye<Judged> measured() const {
    const std::span<const Row> rows = bundled_rows();
    const auto row = std::find_if(rows.begin(), rows.end(), [&](const Row& candidate) {
      return std::string_view(candidate.scene) == GetParam() && candidate.pose == pose_;
    });
    return row->ages.at(0).eyes;
  }

  std::string pose_;
  PerEye<Image<Rgb8>> reference_;
};

TEST_P(PoseDeltaFault, RefusesMasksOfSwappedEyes) {
  for (const char* pose : {"Yaw1", "Step1cm", "EyeDistance70mm"}) {
    Mask mask = ask(pose);
    std::swap(mask.bits[0], mask.bits[1]);
    expect_refused(rig_.show(views_.shown, {mask.traced_mask()}).pictures, "swapped_eyes");
  }
}

/// The shader gets the transform from traced to shown eyes instead of the one from shown to traced eyes.
TEST_P(PoseDeltaFault, RefusesAnInvertedDelta) {
  for (const char* pose : {"Yaw1", "Step10cm", "Yaw5Step10cm", "Roll10"}) {
    Mask mask = ask(pose);
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      const Rigid<Stage, Eye>& shown = views_.shown[eye].stage_from_eye;
      mask.views[eye].stage_from_eye = shown * (inverse(views_.traced[eye].stage_from_eye) * shown);
    }
    expect_refused(rig_.show(views_.shown, {mask.traced_mask()}).pictures, "inverted_delta");
  }
}

void copy_pixel(const EyeMask& from, EyeMask& to, std::size_t pixel) {
  const auto x = static_cast<std::uint32_t>(pixel % kDeltaSide_px),
             y = static_cast<std::uint32_t>(pixel / kDeltaSide_px);
  for (std::uint32_t plane = 0; plane < from.layout().planes(); ++plane)
    to.set_word(x, y, plane, from.word(x, y, plane));
}

/// No option turns the test off. So a mask is made that has the bits which the newest view would give without
/// the test, at the pixels where that view did not see the surface, and is shown at the same pixels.
TEST_P(PoseDeltaFault, RefusesADroppedSameSurfaceTest) {
  for (const char* pose : {"Step10cm", "Step50cm", "Yaw5Step10cm"}) {
    const Mask mask = ask(pose);
    const Shown right = rig_.show(views_.shown, {mask.traced_mask()});
    const PerEye<Image<float>> distance_m = rig_.renderer().read_distance();
    Mask tested = mask, dropped = mask;
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      const ShownReport& report = right.reports[eye];
      tested.bits[eye] = report.mask;
      dropped.bits[eye] =
          reprojected_without_test({views_.shown[eye], distance_m[eye]}, views_.traced[eye], mask.bits[eye]);
      for (std::size_t i = 0; i < report.sources.size(); ++i)
        if (report.sources[i] == 0) copy_pixel(report.mask, dropped.bits[eye], i);
    }
    const PerEye<Image<Rgb8>> with = show_as_they_are(tested), without = show_as_they_are(dropped);
    expect_refused(without, "dropped_test");
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      EXPECT_LT(judged(without, eye).psnr_db, judged(with, eye).psnr_db - 2)
          << "the cost of turning the test off";
  }
}

INSTANTIATE_TEST_SUITE_P(, PoseDeltaFault, testing::Values("box_over_plane", "room"),
                         [](const auto& tested) { return std::string(tested.param); });

}  // namespace
}  // namespace farshade
