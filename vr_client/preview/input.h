/// Input: keys and mouse movement since the last poll, independent of the window system.
#pragma once

#include <bitset>
#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

namespace farshade {

/// Keys by their position on a US keyboard.
enum class Key : std::uint8_t {
  // clang-format off
  A, B, C, D, E, F, G, H, I, J, K, L, M, N, O, P, Q, R, S, T, U, V, W, X, Y, Z,
  Digit0, Digit1, Digit2, Digit3, Digit4, Digit5, Digit6, Digit7, Digit8, Digit9,
  F1, F2, F3, F4, F5, F6, F7, F8, F9, F10, F11, F12,
  Space, Tab, Enter, Escape, Left, Right, Up, Down, Home, End,
  Plus, Minus, LeftBracket, RightBracket, Comma, Period, Shift, Control,
  // clang-format on
};
inline constexpr std::size_t kKeys = static_cast<std::size_t>(Key::Control) + 1;

/// Input that the panel has used is not included.
struct Input {
  std::vector<Key> pressed;  ///< in order, without key repeats
  std::bitset<kKeys> held;   ///< keys that are down now, indexed by Key
  glm::dvec2 drag_px{0, 0};  ///< mouse movement with the left button down: x to the right, y down
  double scroll = 0;         ///< notches of the wheel; positive is away from the viewer

  [[nodiscard]] bool holds(Key key) const { return held[static_cast<std::size_t>(key)]; }
};

}  // namespace farshade
