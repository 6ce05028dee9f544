/// LifeCycle: the life of an OpenXR session as a value. `after` gives the next value for an event, and what
/// the client must do now. Nothing here calls OpenXR. Source: OpenXR 1.0 specification, section "Session
/// Lifecycle".
#pragma once

#include <cstdint>
#include <variant>

namespace farshade::openxr {

/// XrSessionState. None: no event has come since the session was created.
enum class SessionState : std::uint8_t {
  None,
  Idle,
  Ready,
  Synchronized,
  Visible,
  Focused,
  Stopping,
  LossPending,
  Exiting
};
[[nodiscard]] const char* name_of(SessionState state);

/// The specification lets a runtime change from one state to the other.
[[nodiscard]] bool is_in_table(SessionState from, SessionState to);

// Events.
struct StateChanged {
  SessionState to;
};                       ///< XrEventDataSessionStateChanged
struct SessionBegan {};  ///< xrBeginSession has succeeded
struct SessionEnded {};  ///< xrEndSession was called; a session is not running after it, whatever it returned
struct SessionReplaced {};      ///< a new session was created
struct SessionLost {};          ///< a call returned XR_ERROR_SESSION_LOST
struct InstanceLossPending {};  ///< XrEventDataInstanceLossPending
struct InstanceLost {};         ///< a call returned XR_ERROR_INSTANCE_LOST
struct ExitWanted {};           ///< the user wants to end the client; may come again and again
using Event = std::variant<StateChanged, SessionBegan, SessionEnded, SessionReplaced, SessionLost,
                           InstanceLossPending, InstanceLost, ExitWanted>;

/// What the client must do after an event.
enum class Act : std::uint8_t {
  Nothing,
  Begin,        ///< call xrBeginSession, then give SessionBegan
  End,          ///< call xrEndSession, then give SessionEnded
  RequestExit,  ///< call xrRequestExitSession
  Replace,      ///< destroy the session, create another when there is a headset again, give SessionReplaced
  Finish,       ///< destroy the session and end
};

/// Why the last session ended.
enum class Ending : std::uint8_t {
  None,
  Wanted,        ///< the user has ended the client
  Exiting,       ///< the runtime has ended the session for good
  InstanceLost,  ///< the runtime itself ends
};

struct LifeCycle {
  SessionState state = SessionState::None;
  enum class Session : std::uint8_t { NotRunning, Running } session = Session::NotRunning;
  enum class Exit : std::uint8_t { NotWanted, Wanted, Requested } exit = Exit::NotWanted;
  Ending ending = Ending::None;

  /// Frames must be waited for, begun and ended. Otherwise only events are polled.
  [[nodiscard]] bool has_frames() const {
    return session == Session::Running && state != SessionState::Stopping && ending == Ending::None;
  }
  friend bool operator==(const LifeCycle&, const LifeCycle&) = default;
};

struct Step {
  LifeCycle now;
  Act act = Act::Nothing;
  friend bool operator==(const Step&, const Step&) = default;
};

/// Follows the runtime also where it changes to a state that the specification does not allow. After an
/// ending nothing changes any more, and the act is Finish.
[[nodiscard]] Step after(LifeCycle before, const Event& event);

}  // namespace farshade::openxr
