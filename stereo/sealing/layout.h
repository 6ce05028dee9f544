/// The layout of the messages as a hash, which is a part of the protocol's version (version.h): the kinds and
/// widths of all fields of all envelopes and messages. It does not cover what a block of bytes contains, nor
/// what a value means: such a change needs another kProtocolNumber.
#pragma once

#include "stereo/messages/version.h"

namespace farshade {

/// Of all envelopes and messages, in a version that is_spoken: 10 bits.
[[nodiscard]] unsigned layout_hash(ProtocolVersion version);

/// Checks that kLayoutHash is the hash of this program's layout. Otherwise the program would take programs of
/// another layout for its own kind, so call it first.
void check_layout();

}  // namespace farshade
