/// Converts RGB to the colours of H.264 (YUV 4:2:0, BT.709, full range) and back. Uses libswscale with
/// accurate rounding, on planes with room for its wide stores.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "stereo/base/expected.h"
#include "stereo/image/image.h"

struct SwsContext;

namespace farshade {

/// Rows of luma and of two chroma planes. A chroma plane has half the width and half the height.
template <class Byte>
struct YuvPlanes {
  std::array<Byte*, 3> rows;
  std::array<int, 3> stride_bytes;
};

class ColourConverter {
 public:
  enum class To : std::uint8_t { Yuv, Rgb };
  /// For pictures of `size`, with even width and height. Unavailable if libswscale fails.
  [[nodiscard]] static Expected<ColourConverter> create(Extent size, To to);

  [[nodiscard]] Extent size() const { return size_; }

  /// `rgb` has the converter's size. Only the direction that was given to `create` may be called.
  void to_yuv(const Image<Rgb8>& rgb, const YuvPlanes<std::uint8_t>& yuv);
  void to_rgb(const YuvPlanes<const std::uint8_t>& yuv, Image<Rgb8>& rgb);

 private:
  struct FreeScaler {
    void operator()(SwsContext* scaler) const;
  };
  using Scaler = std::unique_ptr<SwsContext, FreeScaler>;
  struct alignas(64) Block {
    std::array<std::uint8_t, 64> bytes;
  };
  ColourConverter(Extent size, Scaler scaler);
  [[nodiscard]] std::uint8_t* plane(std::size_t index);

  Extent size_;
  std::size_t row_blocks_;
  std::vector<Block> planes_;  ///< green, blue, red
  Scaler scaler_;
};

}  // namespace farshade
