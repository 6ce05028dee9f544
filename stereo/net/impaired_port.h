/// A live bad network: a port that treats what arrives at it by a model. Each program's model is thus the
/// network towards it; both programs with one have both directions.
#pragma once

#include <memory>

#include "stereo/net/datagram.h"
#include "stereo/net/impairment.h"

namespace farshade {

class ImpairedPort : public DatagramPort {
 public:
  /// As Impairment::follow. Called by the thread that receives.
  virtual void follow(const LinkModel& model) = 0;
};

/// `inner` with `model` before it. A datagram sets out when it reached `inner`, and `arrived` says when the
/// model lets it arrive: receive() hands out none before. Sends go straight through. No thread of its own:
/// what waits, waits in receive(). `clock` is the one that `inner` waits by, and outlives the port.
[[nodiscard]] std::unique_ptr<ImpairedPort> impaired(std::unique_ptr<DatagramPort> inner,
                                                     const LinkModel& model, const Clock& clock);

}  // namespace farshade
