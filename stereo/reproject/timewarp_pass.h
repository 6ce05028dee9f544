/// TimewarpPass shows a picture that was made for other views in the directions that its pixels had
/// (timewarp.comp). It ignores the eyes' positions, so near objects are displaced by the parallax of the
/// eyes' movement.
#pragma once

#include "stereo/frame/view.h"
#include "stereo/gpu/pass.h"
#include "stereo/gpu/upload_buffer.h"
#include "stereo/image/image.h"

namespace farshade {

/// Maps a pixel position (x, y, 1) of `shown` to (x w, y w, w) in `from`, as if both eyes were at one
/// position. w > 0 in front of `from`. The identity, up to rounding, if both views have one rotation and one
/// window.
[[nodiscard]] glm::dmat3 timewarped_pixel(const View& from, const View& shown);

/// For each eye, the share of shown pixels whose centre is outside of `from`.
[[nodiscard]] PerEye<double> outside_share(const StereoView& from, const StereoView& shown);

class TimewarpPass {
 public:
  /// The picture to turn: the one that was loaded last, or the shown picture.
  enum class Source : std::uint8_t { Loaded, Shown };
  /// Show: the turned picture replaces the shown one; pixels outside of it are black. Add: the picture is a
  /// difference_of, which is added to the shown picture; pixels outside of it do not change.
  enum class Effect : std::uint8_t { Show, Add };

  /// `shown` has one layer per eye, format rgba8 UNORM, usage storage and transfer source, and layout
  /// General. Keeps the reference. No side of a loaded picture is larger than that of `largest`, which is at
  /// least the size of `shown`.
  TimewarpPass(gpu::FramesInFlight& frames, const gpu::Image& shown, Extent largest);

  /// Loads an sRGB picture. Both eyes have one size, which need not be that of `shown`.
  void load(const PerEye<Image<Rgb8>>& picture);

  /// Turns a picture made for `from` to the views `shown`. The views `from` have the size of the picture, the
  /// views `shown` that of the image.
  void record(const vk::raii::CommandBuffer& commands, const StereoView& from, const StereoView& shown,
              Source source, Effect effect);

  [[nodiscard]] std::size_t pipelines() const;
  [[nodiscard]] std::size_t bindings() const { return bindings_.kinds.size(); }

 private:
  const vk::raii::Pipeline& need_pipeline(Effect effect);
  void copy_shown(const vk::raii::CommandBuffer& commands) const;

  const gpu::Device& device_;
  const gpu::Image& shown_;
  Extent size_, largest_;
  Extent loaded_;               ///< size of the loaded picture
  gpu::UploadBuffer picture_;   ///< both eyes, four bytes per pixel
  gpu::UploadBuffer light_of_;  ///< linear light of each sRGB level
  gpu::Bindings bindings_;
  vk::raii::PipelineLayout layout_{nullptr};
  std::array<vk::raii::Pipeline, 2> pipelines_{nullptr,
                                               nullptr};  ///< one for each effect, created at first use
};

}  // namespace farshade
