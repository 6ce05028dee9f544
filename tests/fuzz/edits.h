/// Changes to a datagram by an attacker: another length, and other bytes.
#pragma once

#include <vector>

#include "stereo/messages/messages.h"
#include "tests/fuzz/target.h"

namespace farshade::fuzz {

/// Reads changes from the input. If the first byte has 3 in its low bits, two bytes with a new length follow.
/// Then come at most `most` changes of three bytes: two for the place, one to xor, until the input ends.
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
