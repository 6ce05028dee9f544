/// ShadingPass: carries masks over to the shown views and shades the picture (shade.comp). It owns the masks
/// on the device and, if requested, the report of what each pixel was shaded with.
#pragma once

#include <map>
#include <span>

#include "stereo/draw/gbuffer.h"
#include "stereo/draw/mask_slots.h"
#include "stereo/draw/motion.h"
#include "stereo/draw/shading_pipelines.h"
#include "stereo/draw/shadow_maps.h"
#include "stereo/frame/known_tiles.h"
#include "stereo/frame/shadow_frame.h"

namespace farshade {

/// A mask as the shading pass takes it. The references must be valid until the draw returns.
struct TracedMask {
  FrameId frame;
  Time display_time;        ///< of the request
  Time scene_time;          ///< of the traced scene
  const StereoView& views;  ///< traced views, both of one size
  const PerEye<EyeMask>& masks;
  const PerEye<KnownTiles>& known_tiles;
  std::uint64_t content = 0;  ///< changes whenever the bits or known tiles do
  /// The light set that was traced. Bits of lights that the viewer has changed since are stale.
  LightSetRevision light_set_revision = kFirstLightSet;
};

enum class Lookup : std::uint8_t {
  Reproject,  ///< projects surface points into the traced views
  Direct,     ///< reads the newest mask at the shown pixel, without regard to poses
};
enum class Eyes : std::uint8_t { This, Both };
enum class Gaps : std::uint8_t { Unknown, Neighbours };
enum class Edges : std::uint8_t { Nearest, Filtered };

/// How masks are carried over. The defaults were chosen by measurement (docs/reprojection.md).
struct CarryOver {
  Lookup lookup = Lookup::Reproject;
  Eyes eyes = Eyes::Both;         ///< the eyes whose masks a pixel may use
  Gaps gaps = Gaps::Neighbours;   ///< bits of a point that no view saw
  Edges edges = Edges::Filtered;  ///< visibility near a shadow edge
  friend auto operator<=>(const CarryOver&, const CarryOver&) = default;
};

/// What a pixel was shaded with: the index of a mask in use (0 = newest), plus kOtherEye if that mask was
/// traced for the other eye, plus kNeighbour if its view saw only the surface beside the point; or one of the
/// two last values.
inline constexpr std::uint8_t kOtherEye = FARSHADE_MAX_MASKS, kNeighbour = FARSHADE_NEIGHBOUR,
                              kSourceUnknown = FARSHADE_SOURCE_UNKNOWN,
                              kSourceUncovered = FARSHADE_SOURCE_UNCOVERED;

/// What each pixel of one eye was shaded with; pixels in row order. A light that is off has visibility 0 and
/// is neither unknown nor stale.
struct ShownReport {
  EyeMask mask;  ///< the lights with a visibility of at least one half
  std::vector<std::uint8_t> sources;
  std::vector<std::array<float, 2>> positions;  ///< of the point in the source's view, pixels
  std::vector<std::uint8_t> visibility;         ///< [pixel][light], 255 = 1; for unknown bits the guess
  /// [pixel][plane], bits as in the mask's planes: guessed; stale; taken from a neighbour, because the mask
  /// that saw the point is too old for this light.
  std::vector<std::uint32_t> unknown, stale, beside;
  /// [pixel]: how many lights would shine there without shadows. A tracer of the same view needs about as
  /// many shadow rays. It differs from a tracer's count in three ways: the tracer skips lights behind the
  /// geometric normal, traces lights of intensity 0, and rounds differently at grazing angles.
  std::vector<std::uint16_t> rays{};
};

/// A light that no mask in use knows at a pixel is shown as the newest mask has it in the direction of that
/// pixel, or with this visibility if there is no mask or the head has turned too far.
inline constexpr float kUnknownVisibility = 1.0f;

/// A mask and what has moved since it was traced.
struct DatedMask {
  const TracedMask& mask;
  Motion motion;
};

class ShadingPass {
 public:
  /// Shown views have `size` pixels an eye; masks have the layout of the plan and at most `traced_size`
  /// pixels. `frame` holds the FrameData that `prepare` fills. Keeps the references except `motion`.
  ShadingPass(const gpu::Device& device, const DrawPlan& plan, const GBufferPass& gbuffer,
              const DepthRing& ring, const gpu::Buffer& frame, const MotionModel& motion, Extent size,
              Extent traced_size);

  static constexpr std::size_t kMaxMasks = FARSHADE_MAX_MASKS;

  /// Prepares `record` with at most most_masks(plan) masks, newest first. Each mask needs its depth in the
  /// ring, unless the lookup is Direct. The left eye's shown depth is in layer `shown_layer`. If the plan
  /// does not carry masks over, the lookup is Direct.
  void prepare(std::uint32_t shown_layer, const StereoView& views, const LightSet& lights,
               std::span<const DatedMask> masks, const CarryOver& carry_over);

  /// The same with shadows from `maps`, which must exist until `record` and be readable by shaders there.
  void prepare(std::uint32_t shown_layer, const StereoView& views, const LightSet& lights,
               const ShadowMaps& maps);

  enum class Report : std::uint8_t { Off, On };
  void record(const vk::raii::CommandBuffer& commands, Report report);

  /// Forgets the masks on the device, because frame ids begin anew.
  void forget() { slots_.clear(); }

  /// The shaded picture: both eyes, sRGB with alpha 255; in layout General after `record`.
  [[nodiscard]] const gpu::Image& shown() const { return shown_; }
  /// The report of the last `record` with Report::On. Call after the device has finished.
  [[nodiscard]] ShownReport report(Side side) const;

  [[nodiscard]] std::size_t pipelines() const { return pipelines_.count(); }
  [[nodiscard]] std::size_t bindings() const;
  [[nodiscard]] std::size_t lookups() const { return masks_ * (other_eye_ ? 2 : 1); }
  [[nodiscard]] std::uint64_t mask_uploads() const { return mask_uploads_; }

 private:
  [[nodiscard]] ShadingKey key_of(std::uint32_t pass, Report report, std::uint32_t eye) const;
  const vk::raii::Pipeline& need_pipeline(std::uint32_t pass, Report report, std::uint32_t eye);
  void make_all_pipelines();
  void assume_nothing();
  void make_buffers(const MotionModel& motion);
  void make_sets(const GBufferPass& gbuffer);
  std::vector<std::size_t> make_resident(std::span<const DatedMask> masks);
  [[nodiscard]] bool upload(std::size_t slot, const TracedMask& mask) const;
  void write_sources(const StereoView& views, std::span<const DatedMask> masks, gpu::FrameData& frame);
  void write_motion(const StereoView& views, std::span<const DatedMask> masks, gpu::FrameData& frame);
  void write_frame(const StereoView& views, const LightSet& lights, const gpu::FrameData& frame);
  void make_report_buffer();
  const vk::raii::PipelineLayout& need_layout(Report report);
  [[nodiscard]] std::vector<const gpu::Bindings*> sets(Report report) const;
  void bind_sets(const vk::raii::CommandBuffer& commands, Report report);
  void shade_carried_over(const vk::raii::CommandBuffer& commands, Report report);
  void shade_all(const vk::raii::CommandBuffer& commands, std::uint32_t pass, Report report);
  void shade_listed(const vk::raii::CommandBuffer& commands, std::uint32_t pass, Report report);

  const gpu::Device& device_;
  const DrawPlan& plan_;
  const DepthRing& ring_;
  const gpu::Buffer& frame_buffer_;
  Extent size_;
  ShadingBytes bytes_;
  gpu::Buffer light_buffer_, mask_buffer_, known_buffer_, report_buffer_;
  gpu::Buffer motion_slots_, motion_buffer_, hard_buffer_;
  std::size_t motion_count_;  ///< of instances that can move
  gpu::Image shown_;
  vk::raii::Sampler nearest_{nullptr};
  gpu::Bindings bindings_;
  gpu::Bindings report_bindings_;  ///< the last set; empty until a report is requested
  std::map<std::size_t, vk::raii::PipelineLayout> layouts_;  ///< by the sets that they contain
  ShadingPipelines pipelines_;
  MaskSlots slots_;
  std::array<bool, kMaxMasks> slot_is_whole_{};  ///< every tile of the slot's mask is known
  std::uint64_t mask_uploads_ = 0;
  // State of the frame that was prepared last.
  const ShadowMaps* maps_ = nullptr;  ///< null: visibilities come from masks
  CarryOver carry_over_;
  bool other_eye_ = false;  ///< masks traced for the other eye are sources
  std::size_t masks_ = 0;
  std::bitset<kMaxLights> off_;                      ///< lights that are off
  bool whole_ = false;                               ///< every tile of every mask is known
  bool moved_ = false, moved_since_newest_ = false;  ///< AnyMotion
};

}  // namespace farshade
