/// Text of others, for messages.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace farshade {

/// `text` for an error message: at most 80 characters, with ? for everything but printable ASCII.
[[nodiscard]] inline std::string printable(std::string_view text) {
  std::string result(text.substr(0, 80));
  std::replace_if(
      result.begin(), result.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return result;
}

}  // namespace farshade
