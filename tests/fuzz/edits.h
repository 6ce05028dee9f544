/// What an attacker does to a datagram: makes it shorter or longer, and changes bytes anywhere.
#pragma once

#include <vector>

#include "stereo/wire/messages.h"
#include "tests/fuzz/target.h"

namespace farshade::fuzz {

/// A byte: with 3 in its low bits two bytes of a new length follow; then changes of two bytes and one, place
/// and xor, until the input or `most` of them end.
inline std::vector<std::byte> edited(std::span<const std::byte> datagram, Choices& choices,
                                     std::uint32_t most = 64) {
  std::vector<std::byte> bytes(datagram.begin(), datagram.end());
  if (choices.up_to(3) == 3) bytes.resize(choices.up_to(kMaxDatagram_bytes));
  for (; most > 0 && !choices.rest().empty() && !bytes.empty(); --most) {
    const std::size_t place = choices.up_to(kMaxDatagram_bytes - 1) % bytes.size();
    bytes[place] ^= static_cast<std::byte>(choices.up_to(255));
  }
  return bytes;
}

}  // namespace farshade::fuzz
