#include "stereo/messages/refusal.h"

namespace farshade {

std::string_view name_of(WireRefusal refusal) {
  static constexpr std::array<std::string_view, kWireRefusals> names{
      "too long",    "truncated",   "magic",     "version",   "type",       "view range",      "time range",
      "frame order", "code",        "lights",    "mask size", "tile range", "trailing bytes",  "block",
      "tile coding", "tile length", "tile bits", "arrivals",  "padding",    "unknown session", "counter jump",
      "replayed",    "forged",      "answer",    "part",      "other mask"};
  return names[static_cast<std::size_t>(refusal)];
}

}  // namespace farshade
