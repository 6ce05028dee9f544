/// The heap of a program that allocates the same large blocks in every frame.
#pragma once

namespace farshade {

/// Keeps freed memory in the program, for the blocks of the next frame. By default, glibc gives it back to
/// the system and lets the system clear it again: with lavapipe, that took half of a client's frame
/// (client_bench, room, 256x256: 57 ms, without it 29 ms). Does nothing with other C libraries. Call once, at
/// the start.
void keep_freed_memory();

}  // namespace farshade
