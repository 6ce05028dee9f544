/// Range coder: codes binary decisions with adaptive probabilities.
///
/// G. N. N. Martin, "Range encoding: an algorithm for removing redundancy from a digitised message", 1979.
/// The interval is halved in proportion to a 12-bit probability that adapts by a shift, as in the LZMA SDK
/// (I. Pavlov). The encoder propagates carries into the bytes that it has written. PROTOCOL.md has the
/// arithmetic.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace farshade {

/// The probability of a 0 in one context, in 1/4096. It stays between 8 and 4088, so that each decision costs
/// more than 1/512 bit and a short message cannot hold very many of them.
class BitModel {
 public:
  static constexpr std::uint32_t kBits = 12, kShift = 4;

  BitModel() = default;
  /// From a table of initial probabilities in 1/256.
  explicit constexpr BitModel(std::uint8_t initial) : zero_(static_cast<std::uint16_t>(16 * initial + 8)) {}

  [[nodiscard]] std::uint32_t zero() const { return zero_; }
  /// Moves by 1/16 of the way to the decision's value, rounded down.
  void learn(bool value) {
    const int offset = value ? 0 : (1 << kShift) - 1 - (1 << kBits);
    zero_ = static_cast<std::uint16_t>(zero_ - ((zero_ + offset) >> kShift));
  }

 private:
  std::uint16_t zero_ = 1u << (kBits - 1);
};

inline constexpr std::uint32_t kLeastRange = 1u << 24;
/// Zeros at the end of a coded message that are not sent.
inline constexpr std::size_t kOmitted_bytes = 3;

/// RangeEncoder and RangeDecoder have the same functions, so that one function can be both the encoder and
/// the decoder of something: the encoder codes `value`, the decoder sets it. A loop of many decisions copies
/// the coder, works with the copy, which the compiler keeps in registers, and assigns it back.
class RangeEncoder {
 public:
  /// Replaces the content of `bytes`, which must outlive the encoder.
  explicit RangeEncoder(std::vector<std::byte>& bytes) : bytes_(&bytes) { bytes.clear(); }

  void bit(BitModel& model, const bool& value) {
    const std::uint32_t bound = (range_ >> BitModel::kBits) * model.zero();
    low_ += value ? bound : 0;
    range_ = value ? range_ - bound : bound;
    model.learn(value);
    while (range_ < kLeastRange) shift();
  }

  /// Sixteen decisions of probability 1/2, lowest bit first.
  void plain(const std::uint16_t& value) {
    for (std::uint32_t i = 0; i < 16; ++i) {
      range_ >>= 1;
      low_ += (value >> i & 1) != 0 ? range_ : 0;
      if (range_ < kLeastRange) shift();
    }
  }

  /// The place in the message after some decisions.
  struct Mark {
    std::size_t size = 0;
    std::uint64_t low = 0;
    std::uint32_t range = 0;
    std::byte last{};
  };
  [[nodiscard]] Mark mark() const {
    return {bytes_->size(), low_, range_, bytes_->empty() ? std::byte{} : bytes_->back()};
  }
  /// Forgets all decisions after `mark`. The models are not restored.
  void rewind(const Mark& mark);

  /// The size of the message if it ended here.
  [[nodiscard]] std::size_t size_bytes() const { return bytes_->size() + 1; }
  /// Ends the message.
  void finish();

 private:
  static constexpr std::uint64_t kCarry = std::uint64_t{1} << 32;

  /// Adds 1 to the number that the bytes are. It does not overflow: the interval lies between 0 and 1.
  static void carry(std::vector<std::byte>& bytes) {
    for (std::size_t i = bytes.size(); i-- > 0;) {
      bytes[i] = static_cast<std::byte>(std::to_integer<unsigned>(bytes[i]) + 1);
      if (bytes[i] != std::byte{0}) return;
    }
  }
  void shift() {
    if (low_ >= kCarry) carry(*bytes_);
    bytes_->push_back(static_cast<std::byte>(low_ >> 24 & 0xff));
    low_ = low_ << 8 & 0xffffffff;
    range_ <<= 8;
  }

  std::vector<std::byte>* bytes_;
  std::uint64_t low_ = 0;  ///< relative to the bytes; from kCarry on it has a carry into them
  std::uint32_t range_ = ~0u;
};

/// Safe on any bytes: after the end it reads zeros and counts them.
class RangeDecoder {
 public:
  explicit RangeDecoder(std::span<const std::byte> bytes) : bytes_(bytes) {
    for (int i = 0; i < 4; ++i) code_ = code_ << 8 | next();
  }

  void bit(BitModel& model, bool& value) {
    const std::uint32_t bound = (range_ >> BitModel::kBits) * model.zero();
    value = code_ >= bound;
    if (value) {
      code_ -= bound;
      range_ -= bound;
    } else {
      range_ = bound;
    }
    model.learn(value);
    while (range_ < kLeastRange) shift();
  }

  void plain(std::uint16_t& value) {
    value = 0;
    for (std::uint32_t i = 0; i < 16; ++i) {
      range_ >>= 1;
      if (code_ >= range_) {
        code_ -= range_;
        value = static_cast<std::uint16_t>(value | 1u << i);
      }
      if (range_ < kLeastRange) shift();
    }
  }

  /// It has read further than an encoder's message allows.
  [[nodiscard]] bool has_failed() const { return missing_ > kOmitted_bytes; }
  /// All bytes are read, and they are those that an encoder writes after the same decisions.
  [[nodiscard]] bool is_at_end() const { return missing_ == kOmitted_bytes && code_ < kLeastRange; }

 private:
  std::uint32_t next() {
    if (at_ < bytes_.size()) return std::to_integer<std::uint32_t>(bytes_[at_++]);
    ++missing_;
    return 0;
  }
  void shift() {
    code_ = code_ << 8 | next();
    range_ <<= 8;
  }

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0, missing_ = 0;
  std::uint32_t code_ = 0, range_ = ~0u;
};

}  // namespace farshade
