/// Colours as H.264 has them: YUV 4:2:0, BT.709, full range, and back to RGB. libswscale with accurate
/// rounding does it, over planes with room for its wide stores.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "stereo/base/expected.h"
#include "stereo/image/image.h"

namespace farshade {

/// Rows of luma and of two chroma planes, each of which has half of both sides.
template <class Byte>
struct YuvPlanes {
  std::array<Byte*, 3> rows;
  std::array<int, 3> stride_bytes;
};

class ColourConverter {
 public:
  enum class To : std::uint8_t { Yuv, Rgb };
  /// For pictures of `size`, both sides even. Unavailable when libswscale will not.
  [[nodiscard]] static Expected<ColourConverter> create(Extent size, To to);
  ColourConverter(ColourConverter&&) noexcept;
  ColourConverter& operator=(ColourConverter&&) noexcept;
  ~ColourConverter();

  [[nodiscard]] Extent size() const { return size_; }

  /// `rgb` is of the size; only that To of `create` may be asked for.
  void to_yuv(const Image<Rgb8>& rgb, const YuvPlanes<std::uint8_t>& yuv);
  void to_rgb(const YuvPlanes<const std::uint8_t>& yuv, Image<Rgb8>& rgb);

 private:
  struct Scaler;
  struct alignas(64) Block {
    std::array<std::uint8_t, 64> bytes;
  };
  ColourConverter(Extent size, std::unique_ptr<Scaler> scaler);
  [[nodiscard]] std::uint8_t* plane(std::size_t index);

  Extent size_;
  std::size_t row_blocks_;
  std::vector<Block> planes_;  ///< green, blue, red
  std::unique_ptr<Scaler> scaler_;
};

}  // namespace farshade
