/// Fixtures of the tests in this folder: lavapipe with validation, a scene with its tracer and renderer
/// (TestRig), heads, and masks that a test may change.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>

#include "stereo/draw/renderer.h"
#include "stereo/gpu/device.h"
#include "stereo/tracer/tracer.h"

namespace farshade {

/// Lavapipe with validation. All tests of the program share one device, because opening one takes longer than
/// most tests. Each test finds an empty ledger and the limits of lavapipe, whatever another test set. A test
/// fails if the validation layers gave a message until the end of the test's members.
class OnLavapipe : public testing::Test {
 protected:
  OnLavapipe();
  ~OnLavapipe() override;

  gpu::Device& device_;

 private:
  std::size_t earlier_messages_;
  std::uint64_t max_allocations_, max_allocation_bytes_;
  std::uint32_t max_image_side_px_, max_image_layers_;
  std::array<std::uint32_t, 2> max_groups_;
  std::uint64_t max_storage_bytes_, max_texels_;
  std::function<decltype(gpu::image_limits)> image_limits_;
};

/// A bundled scene. Throws if it cannot be loaded.
[[nodiscard]] Scene bundled(const char* name);

/// `scene` with `count` lights: its own lights first, then additional point lights around them.
[[nodiscard]] Scene with_lights(Scene scene, std::uint32_t count);

/// The head at the scene's camera.
[[nodiscard]] Rigid<Stage, Head> head_at_camera(const Scene& scene);

/// The head at `eye` that looks at `target`.
[[nodiscard]] Rigid<Stage, Head> head_looking(const glm::dvec3& eye, const glm::dvec3& target);

/// `head` after a turn to its left and a step in its own axes (+x right, -z ahead).
[[nodiscard]] Rigid<Stage, Head> moved(const Rigid<Stage, Head>& head, double yaw_rad,
                                       const glm::dvec3& step_m);

/// Both eyes of `head`, 63 mm apart, with an asymmetric fov of about 63 x 62 degrees.
[[nodiscard]] StereoView eyes_of(const Rigid<Stage, Head>& head, std::uint32_t side_px);

/// A wall with a vertical step in its middle, for tests of what counts as one surface. From left to right on
/// the screen, inverse distance increases by `slope` footprints of a pixel in each pixel, and at the step by
/// `step`, as shares of the inverse distance at the step.
struct SteppedWall {
  std::uint32_t side_px = 0;  ///< of views
  double slope = 0, step = 0;

  [[nodiscard]] Scene scene() const;
  /// Both eyes at the same place, looking along -z. The step is `left_px` pixels left of the middle.
  [[nodiscard]] StereoView views(double left_px) const;
};

/// A mask that owns its data.
struct Mask {
  FrameId frame;
  Time scene_time;
  StereoView views;
  PerEye<EyeMask> bits;
  PerEye<ReceivedTiles> received_tiles;
  LightSetRevision light_set_revision = kFirstLightSet;
  RequestedBlocks requested{};  ///< the others were reprojected

  /// The result refers to this mask.
  [[nodiscard]] TracedMask traced_mask() const;
};

/// Frames of most tests: two masks and the frame that shows them.
inline constexpr FrameId kOlder{1}, kTraced{2}, kNow{3};

/// `mask` with random bits.
[[nodiscard]] Mask with_noise(Mask mask, std::uint64_t seed);

/// The simplest reprojection: the nearest pixel of this eye's masks that saw the same surface.
inline constexpr Reprojection kPlainReprojection{
    .lookup = Lookup::Reproject, .eyes = Eyes::This, .gaps = Gaps::Unknown, .edges = Edges::Nearest};

struct Shown {
  PerEye<Image<Rgb8>> pictures;
  PerEye<ShownReport> reports;
};

[[nodiscard]] bool same_bits(const EyeMask& a, glm::uvec2 at, const EyeMask& b, glm::uvec2 there);

void for_pixels(Extent size, const std::function<void(std::uint32_t x, std::uint32_t y)>& visit);

/// The bits of a mask word that are asked for at `pixel` of views of `size`.
[[nodiscard]] std::uint32_t requested_bits(const RequestedBlocks& requested, std::size_t eye, Extent size,
                                           glm::uvec2 pixel);

/// Calls `visit` for every covered pixel of both eyes.
using Visit = std::function<void(Side, std::uint32_t x, std::uint32_t y, std::uint8_t source)>;
void for_covered(const Shown& shown, const Visit& visit);

/// What edge rays need in a rig with this scene.
[[nodiscard]] EdgeRayData edge_ray_data(const gpu::Device& device, const Scene& scene);

class TestRig {
 public:
  /// Shown eyes have `side_px` x `side_px` pixels. Traced views may be a quarter larger. The renderer allows
  /// for an error of `detail_px` pixels of levels of detail, but draws none. It shades with the `passes` that
  /// the environment variable FARSHADE_PASSES names (sorted, single), or that suit the device.
  TestRig(const gpu::Device& device, Scene scene, std::uint32_t side_px, std::uint32_t depth_frames = 4,
          float detail_px = 0, std::optional<ShadingPasses> passes = {});

  /// A rig whose pictures can have Edges::Exact; in full detail, with sorted passes.
  [[nodiscard]] static TestRig with_edge_rays(const gpu::Device& device, Scene scene, std::uint32_t side_px);
  /// The same with data that the test gives.
  [[nodiscard]] static TestRig with_edge_rays(const gpu::Device& device, Scene scene, std::uint32_t side_px,
                                              FutureEdgeRayData data);

  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] Renderer& renderer() { return *renderer_; }
  [[nodiscard]] Rigid<Stage, Head> head() const { return head_at_camera(scene_); }
  [[nodiscard]] StereoView eyes(const Rigid<Stage, Head>& head) const { return eyes_of(head, side_px_); }

  /// The mask of a full trace at `views`, with all tiles known.
  [[nodiscard]] Mask trace(FrameId frame, const StereoView& views);
  /// The same, and the depth ring keeps the views' depth.
  [[nodiscard]] Mask ask(FrameId frame, const StereoView& views);
  /// `base` reprojected to `views`, at the time and with the lights of the rig. No value: whole views must
  /// be traced.
  [[nodiscard]] std::optional<RequestReprojection> reproject_to_request(FrameId frame,
                                                                        const StereoView& views,
                                                                        const Mask& base);
  /// The same as `ask`, but only the blocks that `base` leaves unknown are traced.
  [[nodiscard]] Mask ask_for_unknown(FrameId frame, const StereoView& views, const Mask& base);
  /// Metres along -z of the views of the last `ask`; 0 for uncovered pixels.
  [[nodiscard]] const PerEye<Image<float>>& requested_distance() const { return requested_distance_; }

  /// The masks of the cube's faces about `centre`, traced at the time of the rig. The renderer keeps their
  /// depth.
  [[nodiscard]] std::vector<Mask> ask_cube_mask(Point<Stage> centre);

  /// Draws `views` with `masks`, newest first, and those of the cube mask, without a request.
  [[nodiscard]] Shown show(const StereoView& views, const std::vector<TracedMask>& masks,
                           const Reprojection& reprojection = {}, const std::vector<Mask>& cube_mask = {});
  /// Draws `views` with shadows traced at these views.
  [[nodiscard]] PerEye<Image<Rgb8>> show_reference(const StereoView& views);

  /// Sets what the lenses hide of shown views. In views that a mask is reprojected to it is less.
  void hide(PerEye<HiddenArea> hidden) { hidden_ = std::move(hidden); }
  /// Sets the time of the scene.
  void set_time(Time scene_time) { state_ = state_at(scene_, scene_time, state_.light_changes); }
  /// Sets the viewer's changes of the lights.
  void set_lights(const LightChanges& changes) { state_ = state_at(scene_, state_.scene_time, changes); }

 private:
  TestRig(const gpu::Device& device, Scene scene, std::uint32_t side_px, std::uint32_t depth_frames,
          const std::function<DrawPlan(const Scene&)>& plan_of, FutureEdgeRayData edge_rays = {});
  [[nodiscard]] ShownFrame shown_frame(const StereoView& views, std::span<const TracedMask> masks,
                                       const Reprojection& reprojection) const;

  Scene scene_;
  SceneState state_;
  std::uint32_t side_px_, depth_frames_;
  std::unique_ptr<Tracer> tracer_;
  std::unique_ptr<Renderer> renderer_;
  PerEye<Image<float>> requested_distance_;
  std::optional<PerEye<HiddenArea>> hidden_;
};

}  // namespace farshade
