#include "rt_server/answers/device_recovery.h"

#include <spdlog/spdlog.h>

#include "stereo/gpu/device.h"

namespace farshade {
namespace {

class Recovering final : public RequestHandler {
 public:
  Recovering(std::unique_ptr<RequestHandler> handler, std::shared_ptr<DeviceRecovery> recovery)
      : recovery_(std::move(recovery)), handler_(std::move(handler)) {}

  AnswerCost answer(const Job& job, FramePacker& packer) override {
    return recovery_->answer(*handler_, job, packer);
  }

 private:
  std::shared_ptr<DeviceRecovery> recovery_;
  std::unique_ptr<RequestHandler> handler_;
};

[[noreturn]] void give_up(const std::string& why) {
  throw AnswersLost(kDrawnAnswers,
                    "pictures need a device, and " + why + "; restart the server to offer them");
}

}  // namespace

AnswerCost DeviceRecovery::answer(RequestHandler& handler, const Job& job, FramePacker& packer) {
  try {
    const AnswerCost cost = handler.answer(job, packer);
    losses_.add_work();
    return cost;
  } catch (const vk::DeviceLostError& lost) {
    const std::string why = lost.what();
    if (losses_.add_loss()) give_up(fmt::format("it was lost {} times in a row: {}", kMostLosses, why));
    if (const Expected<void> opened = reopen_(); !opened)
      give_up(fmt::format("it was lost ({}) and cannot be opened again: {}", why, opened.error().what));
    throw std::runtime_error("the device was lost and has been opened again: " + why);
  }
}

std::unique_ptr<RequestHandler> recovering(std::unique_ptr<RequestHandler> handler,
                                           std::shared_ptr<DeviceRecovery> recovery) {
  return std::make_unique<Recovering>(std::move(handler), std::move(recovery));
}

}  // namespace farshade
