/// Renderer: one shown frame, from views to pixels: G-buffer, the depth of what is asked for, then masks
/// carried over and shaded. One frame at a time; draw returns when the device has finished.
#pragma once

#include "stereo/draw/counters.h"
#include "stereo/draw/gbuffer_transfer.h"
#include "stereo/draw/shading.h"
#include "stereo/draw/shadow_map_settings.h"
#include "stereo/draw/turn_pass.h"
#include "stereo/image/image.h"
#include "stereo/plan/scene_plan.h"

namespace farshade {

struct DrawTimes {
  Duration gbuffer{}, depth{}, shade{};  ///< on the device; depth: of requested views that are not shown
  Duration maps{};                       ///< shadow maps, on the device; 0 where they stay as they were
  Duration turn{};                       ///< of a picture made for other views, on the device
  Duration total{};                      ///< wall time of the call: recording, uploads, submission, wait
};

struct ShownFrame {
  StereoView views;  ///< both eyes of the renderer's size
  const SceneState& state;
  const FrameRequest* asked = nullptr;  ///< this frame's request; the depth of its views is kept
  std::span<const TracedMask> masks;  ///< newest first; those whose depth is not in the ring are passed over
  CarryOver carry_over;
  ShadingPass::Report report = ShadingPass::Report::Off;
  /// Set: shadows come from maps that are drawn for this frame, and `masks` are not read. One that
  /// shadow_map_bytes does not refuse for the scene.
  const ShadowMapSettings* shadow_maps = nullptr;
  std::size_t asked_slot = 0;  ///< where the depth is kept: the slot of the request's record
};

/// How large the renderer's pictures and masks may be, and how long requests are remembered.
struct RendererLimits {
  Extent size;                     ///< pixels of a shown eye
  Extent traced_size;              ///< of a traced eye at most
  std::uint32_t depth_frames = 8;  ///< slots for the depth of requests
};

class Renderer {
 public:
  /// References are kept. `plan` is that of `scene`, which has the lights that the plan keeps. Throws when
  /// the device runs out of memory.
  Renderer(const gpu::Device& device, const Scene& scene, DrawPlan plan, const RendererLimits& limits);
  /// For any session with all of the scene's lights.
  Renderer(const gpu::Device& device, const Scene& scene, const RendererLimits& limits);

  DrawTimes draw(const ShownFrame& frame);

  /// Shades the last frame drawn again: the same views and state, other masks or another way to carry them
  /// over.
  DrawTimes shade_again(const ShownFrame& frame);

  /// The G-buffer pass alone: what a client without shadows would pay. Keeps its depth for `asked`.
  DrawTimes draw_gbuffer(const ShownFrame& frame);

  /// Draws the depth of what `asked` sees, keeps it for the request's masks, and reads it: metres along -z, 0
  /// where nothing is covered, into images whose memory is reused. `slot` is that of the request's record.
  DrawTimes keep_depth(const FrameRequest& asked, std::size_t slot, PerEye<Image<float>>& into);

  /// Shades `planes` that another renderer read at `frame.views`, instead of drawing; masks are read pixel by
  /// pixel (Lookup::Direct), and nothing is kept for requests. Same planes, masks and lights: same picture.
  DrawTimes draw_received(const GBufferPlanes& planes, const ShownFrame& frame);

  /// Shows `picture`, sRGB, made for `from`, turned to `shown`; all of the renderer's size. What it does not
  /// cover is black, and outside_share of the pixels.
  DrawTimes show_turned(const PerEye<Image<Rgb8>>& picture, const StereoView& from, const StereoView& shown);

  /// The same of what is shown already, which was made for `from`.
  DrawTimes turn_shown(const StereoView& from, const StereoView& shown);

  /// Draws `frame` without shadows, whatever masks it has, and adds `difference`, a difference_of made for
  /// `from`, turned to the frame's views. What it does not cover has no shadows.
  DrawTimes draw_with_difference(const ShownFrame& frame, const PerEye<Image<Rgb8>>& difference,
                                 const StereoView& from);

  /// No request's depth and no mask is remembered: frame ids begin anew.
  void forget();

  [[nodiscard]] bool has_depth(FrameId frame) const { return ring_.has(frame); }

  // Of the last draw.
  /// Both eyes, for a pass that shows them: two layers, rgba8 UNORM, sampled, in layout General.
  [[nodiscard]] const gpu::Image& shown() const { return shading_.shown(); }
  [[nodiscard]] PerEye<Image<Rgb8>> read_shown() const;
  [[nodiscard]] ShownReport report(Side side) const { return shading_.report(side); }
  /// Metres along -z, 0 where nothing is covered.
  [[nodiscard]] PerEye<Image<float>> read_distance() const;
  /// Into planes whose memory is reused.
  void read_gbuffer(GBufferPlanes& into) const { transfer_.read(shown_depth_, into); }

  [[nodiscard]] DrawCounters counters() const;

 private:
  enum class Stage : std::uint8_t { GBuffer, Shade, Both, Received };
  void place_depth(const ShownFrame& frame);
  void make_depth_pass();
  void prepare_shading(const ShownFrame& frame);
  ShadowMaps& need_maps(const ShadowMapSettings& wish);
  DrawTimes submit(const ShownFrame& frame, Stage stage);
  TurnPass& need_turn();
  Duration submit_turn(const StereoView& from, const StereoView& shown, TurnPass::Source source,
                       TurnPass::Effect effect);
  void read_back(const gpu::Image& image, vk::ImageLayout layout, gpu::LayerRange layers, Extent size) const;
  void read_distance(DepthRing::Place place, Extent size, PerEye<Image<float>>& into) const;

  const gpu::Device& device_;
  const Scene& scene_;
  const DrawPlan plan_;
  Extent size_;
  SceneBuffers buffers_;
  MotionModel motion_;
  gpu::Buffer frame_buffer_;  ///< one FrameData, which all passes read
  DepthRing ring_;
  GBufferPass gbuffer_;
  mutable GBufferTransfer transfer_;
  std::optional<DepthPass> depth_pass_;    ///< once it is needed
  std::optional<ShadowMaps> shadow_maps_;  ///< once they are wished for
  ShadingPass shading_;
  std::optional<TurnPass> turn_;                 ///< once a picture is turned
  DepthRing::Place shown_depth_;                 ///< of the last frame drawn
  std::optional<DepthRing::Place> asked_depth_;  ///< where the depth pass draws, if it has to
  vk::raii::CommandBuffer commands_{nullptr};
  vk::raii::Fence fence_{nullptr};
  gpu::Timestamps stamps_;
  mutable gpu::Buffer readback_;  ///< once anything is read back
};

}  // namespace farshade
