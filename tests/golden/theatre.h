/// Theatre: what every test here stands on - lavapipe with validation, a scene with its tracer and renderer,
/// heads, and masks that a test may spoil.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <glm/vec2.hpp>
#include <memory>

#include "stereo/draw/renderer.h"
#include "stereo/tracer/tracer.h"

namespace farshade {

/// Opens lavapipe with validation on. Each test ends by expecting that the layers said nothing.
class OnLavapipe : public testing::Test {
 protected:
  OnLavapipe();
  void TearDown() override;

  gpu::Device device_;
};

/// A bundled scene; the test fails where it cannot be loaded.
[[nodiscard]] Scene bundled(const char* name);

/// `scene` with its first lights and, where it has fewer than `count`, further point lights about them.
[[nodiscard]] Scene with_lights(Scene scene, std::uint32_t count);

/// The head that stands at the scene's camera.
[[nodiscard]] Rigid<Stage, Head> head_at_camera(const Scene& scene);

/// The head that stands at `eye` and looks at `target`.
[[nodiscard]] Rigid<Stage, Head> head_looking(const glm::dvec3& eye, const glm::dvec3& target);

/// `head` after a turn to its left and a step in its own axes (+x right, -z ahead).
[[nodiscard]] Rigid<Stage, Head> moved(const Rigid<Stage, Head>& head, double yaw_rad,
                                       const glm::dvec3& step_m);

/// Both eyes of `head`, 63 mm apart, with an asymmetric fov of about 63 x 62 degrees.
[[nodiscard]] StereoView eyes_of(const Rigid<Stage, Head>& head, std::uint32_t side_px);

/// A mask that owns what it says.
struct Mask {
  FrameId frame;
  Time scene_time;
  StereoView views;
  PerEye<EyeMask> bits;
  PerEye<KnownTiles> known_tiles;
  LightSetRevision light_set_revision = kFirstLightSet;

  /// Refers to this mask.
  [[nodiscard]] TracedMask in_hand() const;
};

/// All bits of `mask` drawn anew from a stated seed.
[[nodiscard]] Mask with_noise(Mask mask, std::uint64_t seed);

/// The bare lookup: the nearest pixel of this eye's masks that saw the same surface, or nothing.
inline constexpr CarryOver kPlainCarryOver{
    .lookup = Lookup::Reproject, .eyes = Eyes::This, .gaps = Gaps::Unknown, .edges = Edges::Nearest};

struct Shown {
  PerEye<Image<Rgb8>> pictures;
  PerEye<ShownReport> reports;
};

[[nodiscard]] bool same_bits(const EyeMask& a, glm::uvec2 at, const EyeMask& b, glm::uvec2 there);

/// Calls `visit` for every covered pixel of both eyes.
using Visit = std::function<void(Side, std::uint32_t x, std::uint32_t y, std::uint8_t source)>;
void for_covered(const Shown& shown, const Visit& visit);

class Theatre {
 public:
  /// Eyes of `side_px`; traced views may be a quarter larger.
  Theatre(const gpu::Device& device, Scene scene, std::uint32_t side_px, std::uint32_t depth_frames = 4);

  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] const Renderer& renderer() const { return *renderer_; }
  [[nodiscard]] Rigid<Stage, Head> head() const { return head_at_camera(scene_); }
  [[nodiscard]] StereoView eyes(const Rigid<Stage, Head>& head) const { return eyes_of(head, side_px_); }

  /// The full trace at `views`, all tiles known.
  [[nodiscard]] Mask trace(FrameId frame, const StereoView& views);
  /// As trace, and the views' depth goes into the ring.
  [[nodiscard]] Mask ask(FrameId frame, const StereoView& views);

  /// Shows `views` with `masks`, newest first, and asks for nothing.
  [[nodiscard]] Shown show(const StereoView& views, const std::vector<TracedMask>& masks,
                           const CarryOver& carry_over = {});
  /// The picture with every pixel's shadows traced at `views`.
  [[nodiscard]] PerEye<Image<Rgb8>> show_reference(const StereoView& views);

  /// Where everything stands from now on: the scene at `scene_time`.
  void set_time(Time scene_time) { state_ = state_at(scene_, scene_time, state_.light_changes); }
  /// What a viewer has changed about the lights, from now on.
  void set_lights(const LightChanges& changes) { state_ = state_at(scene_, state_.scene_time, changes); }

 private:
  [[nodiscard]] ShownFrame shown_frame(const StereoView& views, std::span<const TracedMask> masks,
                                       const CarryOver& carry_over) const;

  Scene scene_;
  SceneState state_;
  std::uint32_t side_px_, depth_frames_;
  std::unique_ptr<Tracer> tracer_;
  std::unique_ptr<Renderer> renderer_;
};

}  // namespace farshade
