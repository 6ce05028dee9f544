/// The sentence that people read on either side when a server refuses a client.
#pragma once

#include <string>

#include "stereo/wire/messages.h"

namespace farshade {

/// The first eight hexadecimal digits: enough to tell two scenes apart by eye.
[[nodiscard]] std::string short_form(const ContentHash& hash);

/// Why `refusal` answered `hello`, and the cure.
[[nodiscard]] std::string explain(const Refusal& refusal, const Hello& hello);

}  // namespace farshade
