#include "stereo/base/stages.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace farshade {

void Stages::end(std::string_view stage) {
  const Time now = clock_->now();
  auto found = std::ranges::find(stages_, stage, &Stage::name);
  if (found == stages_.end()) found = stages_.insert(found, {std::string(stage), {}});
  found->time += now - std::exchange(last_, now);
}

std::string Stages::in_words() const {
  std::string text = fmt::format("{:.0f} ms", ms_of(total()));
  char mark = ':';
  for (const Stage& stage : stages_) {
    if (ms_of(stage.time) < 0.5) continue;
    text += fmt::format("{} {} {:.0f}", std::exchange(mark, ','), stage.name, ms_of(stage.time));
  }
  return text;
}

}  // namespace farshade
