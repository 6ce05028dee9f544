/// Shading pass: the masks in hand are carried over to the shown views and the formula is evaluated
/// (shade.comp). Owns the device's copy of the mask ring and, when asked for, the report of what each pixel
/// was shown with.
#pragma once

#include <map>
#include <span>

#include "stereo/draw/gbuffer.h"
#include "stereo/draw/motion.h"
#include "stereo/draw/shadow_maps.h"
#include "stereo/frame/known_tiles.h"
#include "stereo/frame/shadow_frame.h"

namespace farshade {

/// A mask as the shading pass takes it, whoever made it. References must outlive the draw.
struct TracedMask {
  FrameId frame;
  Time display_time;        ///< that it was traced for
  Time scene_time;          ///< at which it was traced
  const StereoView& views;  ///< that it was traced for; both eyes of one size
  const PerEye<EyeMask>& masks;
  const PerEye<KnownTiles>& known_tiles;
  std::uint64_t content = 0;  ///< changes whenever bits do
  /// The light set that the mask was traced with: lights that changed after it are stale in this mask.
  LightSetRevision light_set_revision = kFirstLightSet;
};

enum class Lookup : std::uint8_t {
  Reproject,  ///< carry points into the traced views
  Direct,     ///< the newest mask is read at the shown pixel, whatever both see
};
enum class Eyes : std::uint8_t { This, Both };
enum class Gaps : std::uint8_t { Unknown, Neighbours };
enum class Edges : std::uint8_t { Nearest, Filtered };

/// How masks are carried over. The defaults were chosen by measurement (docs/reprojection.md).
struct CarryOver {
  Lookup lookup = Lookup::Reproject;
  Eyes eyes = Eyes::Both;         ///< whose masks an eye may take from
  Gaps gaps = Gaps::Neighbours;   ///< what a point gets that no view saw
  Edges edges = Edges::Filtered;  ///< what a point near a shadow edge gets
  friend auto operator<=>(const CarryOver&, const CarryOver&) = default;
};

/// What a pixel was shown with: a mask in hand (0 = newest), kOtherEye added where it was traced for the
/// other eye, kNeighbour where its view saw only the surface beside the point; or one of the two below.
inline constexpr std::uint8_t kOtherEye = FARSHADE_MAX_MASKS, kNeighbour = FARSHADE_NEIGHBOUR,
                              kSourceUnknown = FARSHADE_SOURCE_UNKNOWN,
                              kSourceUncovered = FARSHADE_SOURCE_UNCOVERED;

/// What each pixel of one eye was shown with; pixels row by row. A light that is off has visibility 0, and is
/// neither unknown nor stale.
struct ShownReport {
  EyeMask mask;  ///< lights shown with a visibility of a half or more
  std::vector<std::uint8_t> sources;
  std::vector<std::array<float, 2>> positions;  ///< where in the source's view the point lies, pixels
  std::vector<std::uint8_t> visibility;  ///< pixel by pixel, of each light, 255 = 1; unknown: the rule's
  /// Pixel by pixel, bits as in the mask's planes: shown by the rule; something has moved since; taken from
  /// beside, since the mask that saw the point is too old for this light.
  std::vector<std::uint32_t> unknown, stale, beside;
  /// Pixel by pixel, how many lights would shine there if nothing stood between: the shadow rays that it
  /// needs. A tracer of the same view spends about as many. It leaves out lights behind the geometric normal,
  /// of which the pass knows nothing, traces lights that are on but have no intensity, and rounds differently
  /// where a light grazes.
  std::vector<std::uint16_t> rays{};
};

/// The stated rule: a pixel-light that nothing in hand knows is shown as the newest mask has it at the shown
/// pixel itself, and with this visibility where there is no mask or the head has turned too far since.
inline constexpr float kUnknownVisibility = 1.0f;

/// A mask with what has moved since it was traced.
struct DatedMask {
  const TracedMask& mask;
  Motion motion;
};

class ShadingPass {
 public:
  /// Shown views of `size`, masks of up to `traced_size` pixels an eye that lie as the plan's; `motion` says
  /// which instances move. `frame` holds the FrameData that `prepare` fills.
  ShadingPass(const gpu::Device& device, const DrawPlan& plan, const GBufferPass& gbuffer,
              const DepthRing& ring, const gpu::Buffer& frame, const MotionModel& motion, Extent size,
              Extent traced_size);

  static constexpr std::size_t kMaxMasks = FARSHADE_MAX_MASKS;

  /// What `record` will shade with: at most most_masks(plan) masks, newest first, each with its depth in the
  /// ring (Direct needs none). The shown views' depth begins at `shown_layer`. Where the plan says that masks
  /// are not carried over, the lookup is Direct.
  void prepare(std::uint32_t shown_layer, const StereoView& views, const LightSet& lights,
               std::span<const DatedMask> masks, const CarryOver& carry_over);

  /// The same with shadows from `maps`, which are kept for `record`: there, they are readable by shaders.
  void prepare(std::uint32_t shown_layer, const StereoView& views, const LightSet& lights,
               const ShadowMaps& maps);

  enum class Report : std::uint8_t { Off, On };
  void record(const vk::raii::CommandBuffer& commands, Report report);

  /// No mask is on the device: frame ids begin anew.
  void forget() { resident_.fill({}); }

  /// Both eyes, sRGB with alpha 255; in layout General after `record`.
  [[nodiscard]] const gpu::Image& shown() const { return shown_; }
  /// Of the last `record` with Report::On, after it has finished.
  [[nodiscard]] ShownReport report(Side side) const;

  [[nodiscard]] std::size_t pipelines() const { return pipelines_.size(); }
  [[nodiscard]] std::size_t bindings() const;
  [[nodiscard]] std::size_t lookups() const { return masks_ * (other_eye_ ? 2 : 1); }

 private:
  struct Key {
    std::uint32_t pass;  ///< FARSHADE_PASS_*
    CarryOver carry_over;
    Report report;
    bool whole, moved, moved_since_newest;
    std::uint32_t eye;
    std::uint32_t map_side_px = 0, pcf_radius = 0;  ///< 0: shadows come from masks
    friend auto operator<=>(const Key&, const Key&) = default;
  };
  [[nodiscard]] Key key_of(std::uint32_t pass, Report report, std::uint32_t eye) const;
  const vk::raii::Pipeline& need_pipeline(const Key& key);
  [[nodiscard]] vk::raii::Pipeline make_pipeline(const Key& key);
  void make_all_pipelines();
  void fit_every_frame();
  void make_buffers(const MotionModel& motion);
  void make_sets(const GBufferPass& gbuffer);
  std::size_t make_resident(const TracedMask& mask);
  [[nodiscard]] bool upload(std::size_t slot, const TracedMask& mask) const;
  void list_sources(const StereoView& views, std::span<const DatedMask> masks, gpu::FrameData& frame);
  void tell_carries(const StereoView& views, std::span<const DatedMask> masks, std::size_t mask);
  bool tell_stale(const StereoView& views, std::span<const DatedMask> masks, std::size_t since,
                  gpu::FrameData& frame);
  void tell_frame(const StereoView& views, const LightSet& lights, const gpu::FrameData& frame);
  void make_report_buffer();
  const vk::raii::PipelineLayout& need_layout(Report report);
  [[nodiscard]] std::vector<const gpu::Bindings*> sets(Report report) const;
  void bind_sets(const vk::raii::CommandBuffer& commands, Report report);
  void shade_carried_over(const vk::raii::CommandBuffer& commands, Report report);
  void shade_all(const vk::raii::CommandBuffer& commands, std::uint32_t pass, Report report);
  void shade_listed(const vk::raii::CommandBuffer& commands, std::uint32_t pass, Report report);

  struct Resident {
    std::optional<FrameId> frame;
    std::uint64_t content = 0, used = 0;
    bool whole = false;
  };

  const gpu::Device& device_;
  const DrawPlan& plan_;
  const DepthRing& ring_;
  const gpu::Buffer& frame_buffer_;
  Extent size_;
  ShadingBytes bytes_;
  gpu::Buffer light_buffer_, mask_buffer_, known_buffer_, report_buffer_;
  gpu::Buffer motion_slots_, motion_buffer_, hard_buffer_;
  std::size_t motion_count_;  ///< slots
  gpu::Image shown_;
  vk::raii::Sampler nearest_{nullptr};
  gpu::Bindings bindings_;
  gpu::Bindings report_bindings_;  ///< the last set, once a report has been asked for
  std::map<std::size_t, vk::raii::PipelineLayout> layouts_;  ///< by what they are made of
  std::map<Key, vk::raii::Pipeline> pipelines_;
  std::array<Resident, kMaxMasks> resident_;
  std::uint64_t draws_ = 0;
  const ShadowMaps* maps_ = nullptr;  ///< of the frame at hand; null: shadows come from masks
  CarryOver carry_over_;
  bool other_eye_ = false;  ///< its views are sources
  std::size_t masks_ = 0;
  std::bitset<kMaxLights> off_;                      ///< lights of the frame at hand
  bool whole_ = false;                               ///< no tile is missing in any mask in hand
  bool moved_ = false, moved_since_newest_ = false;  ///< something has, since some mask in hand
};

}  // namespace farshade
