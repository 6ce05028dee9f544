#include "stereo/video/video_unit.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace farshade {
namespace {

/// A parameter set of VideoEncoder has about 30 bytes; what is read of it comes first.
constexpr std::size_t kMostHeader_bytes = 256;
constexpr std::array kStartCode{std::byte{0}, std::byte{0}, std::byte{1}};

/// Reads the bits of a NAL unit's payload. After its end all bits are 0 and has_ended() is true.
class Bits {
 public:
  /// Leaves out emulation prevention bytes (H.264, 7.4.1.1).
  explicit Bits(std::span<const std::byte> payload) {
    for (const std::byte byte : payload.first(std::min(payload.size(), kMostHeader_bytes))) {
      const std::size_t n = bytes_.size();
      const bool prevents =
          byte == std::byte{3} && n >= 2 && bytes_[n - 1] == std::byte{0} && bytes_[n - 2] == std::byte{0};
      if (!prevents || std::exchange(prevented_, true)) bytes_.push_back(byte);
      if (!prevents) prevented_ = false;
    }
  }

  std::uint32_t bits(std::uint32_t count) {
    std::uint32_t value = 0;
    for (; count > 0; --count) {
      const std::size_t byte = next_ / 8;
      value <<= 1;
      if (byte < bytes_.size()) value |= std::to_integer<std::uint32_t>(bytes_[byte] >> (7 - next_ % 8)) & 1;
      ++next_;
    }
    return value;
  }
  /// An Exp-Golomb number (H.264, 9.1). Longer ones than 31 bits end the payload.
  std::uint32_t number() {
    std::uint32_t zeros = 0;
    while (!has_ended() && bits(1) == 0) ++zeros;
    if (zeros > 31) next_ = 8 * bytes_.size() + 1;
    return has_ended() ? 0 : (1u << zeros) - 1 + bits(zeros);
  }
  [[nodiscard]] bool has_ended() const { return next_ > 8 * bytes_.size(); }

 private:
  std::vector<std::byte> bytes_;
  bool prevented_ = false;
  std::size_t next_ = 0;
};

enum NalType : std::uint8_t {
  Slice = 1,
  KeySlice = 5,
  Extra = 6,
  SequenceSet = 7,
  PictureSet = 8,
  Delimiter = 9
};

std::uint32_t rounded_up(std::uint32_t pixels) {
  return (pixels + 15) / 16 * 16;
}

/// Sequence parameter set (H.264, 7.3.2.1.1) up to the cropping.
Expected<void> examine_sequence_set(Bits in, Extent size) {
  const auto unsupported = [] {
    return fail(Fault::Unsupported, "video is not of the format that rt_server makes");
  };
  const std::uint32_t profile = in.bits(8);
  in.bits(16);
  in.number();
  if (profile != 66 && profile != 77 && profile != 100) return unsupported();
  if (profile == 100) {
    const std::uint32_t chroma = in.number(), luma_bits = in.number(), chroma_bits = in.number();
    const std::uint32_t bypass = in.bits(1), scaling = in.bits(1);
    if (chroma != 1 || luma_bits != 0 || chroma_bits != 0 || bypass != 0 || scaling != 0)
      return unsupported();
  }
  in.number();
  const std::uint32_t order = in.number();
  if (order == 0) in.number();
  if (order != 0 && order != 2) return unsupported();
  const std::uint32_t references = in.number();
  in.bits(1);
  const std::uint64_t width = 16 * (std::uint64_t{in.number()} + 1);
  const std::uint64_t height = 16 * (std::uint64_t{in.number()} + 1);
  if (in.bits(1) == 0) return unsupported();  // fields
  in.bits(1);
  if (in.has_ended()) return fail(Fault::Malformed, "a video parameter set ends early");
  if (references > kMostReferences)
    return fail(Fault::OutOfRange, "video with " + std::to_string(references) + " reference pictures");
  if (width != rounded_up(size.width) || height != rounded_up(size.height))
    return fail(Fault::OutOfRange, "video of " + std::to_string(width) + " x " + std::to_string(height) +
                                       " pixels came, " + std::to_string(size.width) + " x " +
                                       std::to_string(size.height) + " were asked for");
  return {};
}

/// What the slices of a unit must keep to.
struct Slices {
  std::size_t count = 0;
  std::optional<std::uint32_t> last_block;

  Expected<void> take(Bits in, std::size_t unit_bytes) {
    const std::uint32_t first_block = in.number();
    if (in.has_ended()) return fail(Fault::Malformed, "a video slice ends early");
    if (last_block && first_block <= *last_block)
      return fail(Fault::Malformed, "a video unit has a slice twice");
    last_block = first_block;
    if (++count > kMostShortSlices + unit_bytes / kLeastMeanSlice_bytes)
      return fail(Fault::Malformed, "a video unit has too many slices");
    return {};
  }
};

}  // namespace

Expected<VideoUnit> examine_unit(std::span<const std::byte> unit, Extent size) {
  VideoUnit content;
  Slices slices;
  for (auto at = unit.begin();
       (at = std::search(at, unit.end(), kStartCode.begin(), kStartCode.end())) != unit.end();) {
    at += kStartCode.size();
    if (at == unit.end()) break;
    const auto type = static_cast<NalType>(std::to_integer<std::uint8_t>(*at) & 0x1f);
    const Bits payload(unit.subspan(static_cast<std::size_t>(at - unit.begin()) + 1));
    Expected<void> fine;
    if (type == SequenceSet) {
      fine = examine_sequence_set(payload, size);
    } else if (type == Slice || type == KeySlice) {
      fine = slices.take(payload, unit.size());
      content.holds_key_frame |= type == KeySlice;
    } else if (type != Extra && type != PictureSet && type != Delimiter) {
      fine = fail(Fault::Unsupported, "video has a NAL unit of type " + std::to_string(type));
    }
    if (!fine) return tl::unexpected(fine.error());
  }
  return content;
}

}  // namespace farshade
