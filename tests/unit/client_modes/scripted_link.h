/// A link whose answers a test supplies: no network, no clock and no server.
#pragma once

#include <functional>

#include "stereo/link/server_connection.h"
#include "tests/support/packed.h"

namespace farshade::modes_test {

inline constexpr Extent kEye{192, 128};
inline constexpr MaskLayout kLayout{1};

class ScriptedLink final : public ServerConnection {
 public:
  explicit ScriptedLink(std::size_t frames = 16) : receiver_(frames, kLayout) { receiver_.begin({}); }

  void request(const FrameRequest& request, Time requested_at, const RequestParts& parts = {}) override {
    sent.push_back(receiver_.ask(request, requested_at, {}, parts.reprojected));
    positions_sent += parts.messages.size();
  }
  bool wait_for(FrameId frame, Duration patience) override {
    waited += patience;
    ++waits;
    if (on_wait) on_wait(frame);
    return receiver_.is_whole(frame);
  }
  [[nodiscard]] bool takes_parts() const override { return true; }
  [[nodiscard]] const FrameReceiver& receiver() const override { return receiver_; }
  [[nodiscard]] const std::optional<Error>& refused() const override { return refused_; }
  [[nodiscard]] Duration busy() const override { return {}; }

  /// Which pieces of an answer arrive.
  enum class Part { FirstSlice, AllSlices, Report, All };

  /// A part of the answer to `frame` arrives: masks that are lit everywhere.
  void deliver(FrameId frame, Part part) {
    const RequestRecord* const record = receiver_.find(frame);
    if (record == nullptr) return;
    ShadowFrame made{frame, record->light_set_revision, record->request.views, {}};
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      made.masks[eye] = EyeMask(record->request.views[eye].size, kLayout);
    FramePacker packer;
    for (const std::vector<std::byte>& datagram : pack(packer, made, {.frame = frame})) {
      const Decoded<ServerMessage> message = decode_server(datagram);
      if (const auto* slice = std::get_if<Slice>(&*message)) {
        if (part != Part::Report) receiver_.take(*slice, {});
        if (part == Part::FirstSlice) return;
      } else if (part == Part::Report || part == Part::All) {
        receiver_.take(std::get<FrameReport>(*message), {});
      }
    }
  }
  void welcome(const Welcome& welcome) { receiver_.begin(welcome); }

  std::vector<FrameRequest> sent;
  std::size_t positions_sent = 0, waits = 0;
  Duration waited{};
  std::function<void(FrameId)> on_wait;

 private:
  FrameReceiver receiver_;
  std::optional<Error> refused_;
};

}  // namespace farshade::modes_test
