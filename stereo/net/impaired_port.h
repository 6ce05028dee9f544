/// ImpairedPort: a port that applies a network model to the datagrams that arrive at it. So the model of each
/// program is the direction towards that program.
#pragma once

#include <functional>
#include <memory>

#include "stereo/net/datagram.h"
#include "stereo/net/impairment.h"

namespace farshade {

class ImpairedPort : public DatagramPort {
 public:
  /// As Impairment::follow. Only the receiving thread may call it.
  virtual void follow(const LinkModel& model) = 0;
};

/// Puts `model` before `inner`. A datagram starts when it reaches `inner`, and `arrived` is the time at which
/// the model lets it arrive; receive() does not return it earlier. Sends are not affected. The port has no
/// thread: all waiting happens in receive(). `clock` must outlive the port. It is the clock of `inner`,
/// unless `own_time` converts the times of `inner` to times of `clock`.
[[nodiscard]] std::unique_ptr<ImpairedPort> impaired(std::unique_ptr<DatagramPort> inner,
                                                     const LinkModel& model, const Clock& clock,
                                                     std::function<Time(Time)> own_time = {});

}  // namespace farshade
