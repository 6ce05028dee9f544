#include "stereo/gltf/gltf_repairs.h"

#include <algorithm>

namespace farshade::gltf {

void Repairs::add(const char* remedy, Error fault) {
  const auto known = std::ranges::find(kinds_, remedy, &Kind::remedy);
  if (known == kinds_.end())
    kinds_.push_back({remedy, std::move(fault)});
  else
    ++known->more;
}

std::vector<std::string> Repairs::sentences() const {
  std::vector<std::string> result;
  for (const Kind& kind : kinds_) {
    result.push_back("repaired: " + kind.first.what + "; " + kind.remedy);
    if (kind.more > 0) result.back() += " (and " + std::to_string(kind.more) + " more)";
  }
  return result;
}

tl::unexpected<Error> Repairs::nothing_to_draw(const std::string& why) const {
  if (kinds_.empty()) return fail(Fault::Malformed, "nothing to draw: " + why);
  const auto not_drawn = std::ranges::find(kinds_, kNotDrawn, &Kind::remedy);
  const Error& first = (not_drawn == kinds_.end() ? kinds_.front() : *not_drawn).first;
  return fail(first.fault, "nothing to draw: " + why + ": " + first.what);
}

}  // namespace farshade::gltf
