/// Stages: how long each stage of a start took, and the whole. A program prints it once it is ready, so that
/// its user sees where the time goes.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "stereo/base/clock.h"

namespace farshade {

class Stages {
 public:
  explicit Stages(const Clock& clock) : clock_(&clock), begin_(clock.now()), last_(begin_) {}

  /// Ends a stage, which began when the last one ended. A stage that ends again gets longer.
  void end(std::string_view stage);

  /// From the construction to the end of the last stage.
  [[nodiscard]] Duration total() const { return last_ - begin_; }

  /// "812 ms: scene 310, device 52, ...", milliseconds. Stages of less than half a millisecond are left out.
  [[nodiscard]] std::string in_words() const;

 private:
  struct Stage {
    std::string name;
    Duration time{};
  };

  const Clock* clock_;
  Time begin_, last_;
  std::vector<Stage> stages_;
};

}  // namespace farshade
