/// Turn pass: a picture made for other views is shown in the direction in which its pixels lay (turn.comp).
/// The eyes' places do not enter, so what is near is wrong by the parallax that the eyes have moved through.
#pragma once

#include "stereo/frame/view.h"
#include "stereo/gpu/pass.h"
#include "stereo/image/image.h"

namespace farshade {

/// Takes a pixel position (x, y, 1) of `shown` to (x w, y w, w) of `from`, both eyes at one place; w > 0
/// ahead of `from`. The identity, to double's rounding, where both look alike.
[[nodiscard]] glm::dmat3 turned_pixel(const View& from, const View& shown);

/// Share of the shown pixels whose centre lies outside of `from`, each eye.
[[nodiscard]] PerEye<double> outside_share(const StereoView& from, const StereoView& shown);

class TurnPass {
 public:
  /// What is turned: the picture loaded last, or what is shown already.
  enum class Source : std::uint8_t { Loaded, Shown };
  /// Show: what the picture does not cover is black. Add: it is a difference_of, added to what is shown;
  /// what it does not cover stays.
  enum class Effect : std::uint8_t { Show, Add };

  /// `shown` has a layer an eye, rgba8 UNORM, storage and transfer source, and rests in layout General. Kept.
  TurnPass(const gpu::Device& device, const gpu::Image& shown);

  /// sRGB, both eyes of the size of `shown`.
  void load(const PerEye<Image<Rgb8>>& picture);

  /// From a picture for `from` to `shown`, both of the size of the image.
  void record(const vk::raii::CommandBuffer& commands, const StereoView& from, const StereoView& shown,
              Source source, Effect effect);
  /// On the device, of the last `record`, after it has finished.
  [[nodiscard]] Duration time() const { return stamps_.between(0, 1); }

  [[nodiscard]] std::size_t pipelines() const;
  [[nodiscard]] std::size_t bindings() const { return bindings_.kinds.size(); }

 private:
  const vk::raii::Pipeline& need_pipeline(Effect effect);
  void copy_shown(const vk::raii::CommandBuffer& commands) const;

  const gpu::Device& device_;
  const gpu::Image& shown_;
  Extent size_;
  gpu::Buffer picture_;   ///< both eyes, four bytes a pixel
  gpu::Buffer light_of_;  ///< of each sRGB level
  gpu::Bindings bindings_;
  vk::raii::PipelineLayout layout_{nullptr};
  std::array<vk::raii::Pipeline, 2> pipelines_{nullptr, nullptr};  ///< of each effect, once it is asked for
  gpu::Timestamps stamps_;
};

}  // namespace farshade
