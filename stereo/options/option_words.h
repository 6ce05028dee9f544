/// Reads the values of options that consist of several numbers or words.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace farshade {

/// The finite number that all of `text` spells.
[[nodiscard]] std::optional<double> number_in(std::string_view text);

/// The parts between the separators; one empty part if the text is empty.
[[nodiscard]] std::vector<std::string_view> split(std::string_view text, char at);

}  // namespace farshade
