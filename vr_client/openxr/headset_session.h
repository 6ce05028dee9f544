/// HeadsetSession: the OpenXR session of a run, from its begin to its end. It polls the events, carries out
/// what they ask for (life_cycle.h), replaces a session that is lost, and keeps what events have said: the
/// focus, the display's rate, what the lenses hide, and other origins of the space. It shows no frames.
#pragma once

#include <string>
#include <vector>

#include "stereo/frame/hidden_area.h"
#include "vr_client/openxr/actions.h"
#include "vr_client/openxr/life_cycle.h"
#include "vr_client/openxr/session.h"

namespace farshade::openxr {

class HeadsetSession {
 public:
  /// Keeps the references.
  HeadsetSession(Instance& instance, const gpu::Device& device, const HeadsetSetup& setup)
      : instance_(instance), device_(device), setup_(setup) {}
  HeadsetSession(const HeadsetSession&) = delete;
  HeadsetSession& operator=(const HeadsetSession&) = delete;
  ~HeadsetSession();

  [[nodiscard]] Expected<void> open();

  /// The run has neither ended nor failed.
  [[nodiscard]] bool goes_on() const { return !failed_ && !abandoned_ && life_.ending == Ending::None; }
  /// Frames must be waited for, begun and ended. Otherwise only events are polled.
  [[nodiscard]] bool has_frames() const { return life_.has_frames(); }
  /// The user wants to end the client.
  [[nodiscard]] bool wants_to_end();
  /// The user has wanted it for longer than the setup allows an exit to take.
  [[nodiscard]] bool is_overdue() const {
    return wanted_end_ && wanted_end_->elapsed() > setup_.longest_exit;
  }

  /// Takes all events that have come.
  void poll_events();
  /// Sleeps where there is no frame to wait for.
  void rest(Duration span) const;
  /// Whether the call has succeeded. A loss is an event of the life cycle, any other failure ends the run.
  [[nodiscard]] bool fine(XrResult result, const char* call);
  /// Ends the run.
  void fail_with(Error error) { failed_ = std::move(error); }
  /// The client wants to end, whether or not the user does. Frames must go on until the run has ended.
  void want_to_end();
  /// A call blocks: leaves everything that it may use to the end of the program, and ends the run.
  void abandon();
  /// The device is lost: destroys the session, which is bound to it.
  void leave_device();
  /// There is a device again in the place of the lost one: makes a session on it, as after a lost session.
  void take_device() { give(SessionLost{}); }
  /// Destroys the session. Returns why the run has failed.
  [[nodiscard]] Expected<void> close();

  /// The current session. There is one while has_frames().
  [[nodiscard]] Session& current() { return *session_; }
  [[nodiscard]] const Actions& actions() const { return *actions_; }
  /// The session has the focus, and had it when this was asked last. Otherwise a button that is held for
  /// another program would seem pressed here all the time.
  [[nodiscard]] bool keeps_focus();
  /// At `time` the space in use has another origin than when this was asked last.
  [[nodiscard]] bool has_recentred(XrTime time);
  /// Of the display, as the runtime states it.
  [[nodiscard]] std::optional<double> refresh_hz() const { return refresh_hz_; }
  /// By the lenses, in this session.
  [[nodiscard]] const PerEye<HiddenArea>& hidden() const { return hidden_; }
  /// The states in their order: "idle, ready, ...".
  [[nodiscard]] const std::string& history() const { return history_; }

 private:
  [[nodiscard]] Expected<void> attach_actions(const Session& session);
  void handle(const XrEventDataBuffer& event);
  void handle_display(const XrEventDataBuffer& event);
  void read_hidden_area();
  void give(const Event& event);
  void carry_out(Act act);
  void replace();
  void end_session();

  Instance& instance_;
  const gpu::Device& device_;
  const HeadsetSetup& setup_;
  std::unique_ptr<Actions> actions_;  ///< of all sessions; null: controllers are not used
  bool lost_focus_ = true;            ///< since keeps_focus() was asked last
  std::unique_ptr<Session> session_;
  PerEye<HiddenArea> hidden_;
  std::optional<double> refresh_hz_;
  LifeCycle life_;
  std::vector<XrTime> recentres_;        ///< at these times the space in use gets another origin
  std::optional<Stopwatch> wanted_end_;  ///< since the user wants to end
  bool abandoned_ = false;
  std::optional<Error> failed_;
  std::string history_;
};

}  // namespace farshade::openxr
