#include "stereo/codec/range_coder.h"

#include "stereo/base/check.h"

namespace farshade {

/// All intervals after the mark lie within the interval of the mark, so at most one carry has come into its
/// bytes, and the last of them shows whether it has.
void RangeEncoder::rewind(const Mark& mark) {
  std::vector<std::byte>& bytes = *bytes_;
  check(mark.size <= bytes.size(), "a mark is in the past");
  bytes.resize(mark.size);
  low_ = mark.low;
  range_ = mark.range;
  if (bytes.empty() || bytes.back() == mark.last) return;
  for (std::size_t i = bytes.size(); i-- > 0;) {
    bytes[i] = static_cast<std::byte>(std::to_integer<unsigned>(bytes[i]) - 1);
    if (bytes[i] != std::byte{255}) return;
  }
}

/// The interval has at least 2^24 numbers, so one of them ends with three zero bytes.
void RangeEncoder::finish() {
  low_ = (low_ + kLeastRange - 1) / kLeastRange * kLeastRange;
  shift();
}

}  // namespace farshade
