/// Shading pass: the masks in hand are carried over to the shown views and the formula is evaluated
/// (shade.comp). Owns the device's copy of the mask ring and, when asked for, the report of what each pixel
/// was shown with.
#pragma once

#include <map>
#include <span>

#include "stereo/frame/known_tiles.h"
#include "stereo/frame/shadow_frame.h"
#include "vr_client/draw/gbuffer.h"

namespace farshade {

/// A mask as the shading pass takes it, whoever made it. References must outlive the draw.
struct MaskInHand {
  FrameId frame;
  Time display_time;        ///< that it was asked for
  const StereoView& views;  ///< that it was traced for; both eyes the size of the shown ones
  const PerEye<EyeMask>& masks;
  const PerEye<KnownTiles>& known_tiles;
  std::uint64_t content = 0;  ///< changes whenever bits do
};

enum class Lookup : std::uint8_t {
  Reproject,  ///< carry points into the traced views
  Direct,     ///< the one mask was traced for the shown views: pixel reads pixel
};

/// Where a pixel's shadow came from: an index into the masks given (0 = newest), or one of the two below.
inline constexpr std::uint8_t kSourceUnknown = FARSHADE_SOURCE_UNKNOWN,
                              kSourceUncovered = FARSHADE_SOURCE_UNCOVERED;

/// What each pixel of one eye was shown with.
struct ShownReport {
  EyeMask mask;                       ///< bits shown; of an unknown pixel the rule's
  std::vector<std::uint8_t> sources;  ///< row-major
};

/// The stated rule: a pixel-light that nothing in hand knows is shown with this visibility.
inline constexpr float kUnknownVisibility = 1.0f;

class ShadingPass {
 public:
  ShadingPass(const gpu::Device& device, const GBufferPass& gbuffer, Extent size, std::uint32_t lights);

  static constexpr std::size_t kMaxMasks = FARSHADE_MAX_MASKS;

  /// What `record` will shade with: at most kMaxMasks masks, newest first, each with its depth in the ring.
  void prepare(FrameId shown, const StereoView& views, const LightSet& lights,
               std::span<const MaskInHand> masks);

  enum class Report : std::uint8_t { Off, On };
  void record(const vk::raii::CommandBuffer& commands, Lookup lookup, Report report);

  /// Both eyes, sRGB with alpha 255; in layout General after `record`.
  [[nodiscard]] const gpu::Image& shown() const { return shown_; }
  /// Of the last `record` with Report::On, after it has finished.
  [[nodiscard]] ShownReport report(Side side) const;

 private:
  struct Key {
    Lookup lookup;
    Report report;
    bool ranges_and_cones, whole;
    std::uint32_t eye;
    friend auto operator<=>(const Key&, const Key&) = default;
  };
  [[nodiscard]] const vk::raii::Pipeline& pipeline(Key key);
  std::size_t make_resident(const MaskInHand& mask);
  [[nodiscard]] bool upload(std::size_t slot, const MaskInHand& mask) const;

  struct Resident {
    std::optional<FrameId> frame;
    std::uint64_t content = 0, used = 0;
    bool whole = false;
  };

  const gpu::Device& device_;
  const GBufferPass& gbuffer_;
  Extent size_;
  MaskLayout mask_;
  std::size_t mask_words_, known_words_;  ///< of one eye
  gpu::Buffer light_buffer_, mask_buffer_, known_buffer_, bits_buffer_, source_buffer_;
  gpu::Image shown_;
  vk::raii::Sampler nearest_{nullptr};
  gpu::Bindings bindings_;
  vk::raii::PipelineLayout layout_{nullptr};
  vk::raii::ShaderModule shader_{nullptr};
  std::map<Key, vk::raii::Pipeline> pipelines_;
  std::array<Resident, kMaxMasks> resident_;
  std::uint64_t draws_ = 0;
  bool ranges_and_cones_ = false;
  bool whole_ = false;  ///< no tile is missing in any mask in hand
};

}  // namespace farshade
