/// MaskBlock: whole masks of both eyes as one LZ4 block, the code of the published systems, to compare with
/// slices (slice.h). It travels in parts as a coded picture does. A mask of which one part is lost is lost.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "stereo/frame/light_changes.h"
#include "stereo/frame/shadow_frame.h"
#include "stereo/messages/messages.h"

namespace farshade {

inline constexpr std::size_t kMostMaskBlock_bytes = kMostVideoParts * kVideoPart_bytes;

/// The light set's revision, then the block. Its content are the bits of the left eye's mask, then those of
/// the right eye's, each from a byte of its own on: light by light, row by row. Returns no bytes if there
/// would be more than kMostMaskBlock_bytes.
[[nodiscard]] std::vector<std::byte> pack_mask_block(const ShadowFrame& frame);

/// The most bytes that pack_mask_block returns for masks like these.
[[nodiscard]] std::size_t most_mask_block_bytes(const PerEye<EyeMask>& masks);

/// Replaces the bits of `masks`, which have the size and the lights that were asked for. Refuses bytes of
/// another light set than `expected`, and all but an LZ4 block with exactly the content of such masks. After
/// a refusal, `masks` are unchanged.
[[nodiscard]] Decoded<void> decode_mask_block(std::span<const std::byte> bytes, LightSetRevision expected,
                                              PerEye<EyeMask>& masks);

}  // namespace farshade
