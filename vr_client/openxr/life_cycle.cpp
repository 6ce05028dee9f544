#include "vr_client/openxr/life_cycle.h"

#include <array>

namespace farshade::openxr {
namespace {

Step finish(LifeCycle now, Ending why) {
  now.ending = why;
  return {now, Act::Finish};
}

/// `now` has just changed to its state.
Step follow(LifeCycle now) {
  const bool running = now.session == LifeCycle::Session::Running;
  const bool wants_to_end = now.exit != LifeCycle::Exit::NotWanted;
  switch (now.state) {
    case SessionState::Ready:
      if (wants_to_end) return finish(now, Ending::Wanted);
      return {now, running ? Act::Nothing : Act::Begin};
    case SessionState::Stopping:
      return {now, running ? Act::End : Act::Nothing};
    case SessionState::LossPending:
      if (wants_to_end) return finish(now, Ending::Wanted);
      now.session = LifeCycle::Session::NotRunning;
      return {now, Act::Replace};
    case SessionState::Exiting:
      return finish(now, wants_to_end ? Ending::Wanted : Ending::Exiting);
    default:
      // A session that the user has ended is idle before it exits, but a runtime may leave it idle.
      return {now, Act::Nothing};
  }
}

struct Apply {
  LifeCycle now;

  Step operator()(const StateChanged& event) {
    now.state = event.to;
    return follow(now);
  }
  Step operator()(SessionBegan) {
    now.session = LifeCycle::Session::Running;
    if (now.exit != LifeCycle::Exit::Wanted) return {now, Act::Nothing};
    now.exit = LifeCycle::Exit::Requested;
    return {now, Act::RequestExit};
  }
  Step operator()(SessionEnded) {
    now.session = LifeCycle::Session::NotRunning;
    if (now.exit != LifeCycle::Exit::NotWanted) return finish(now, Ending::Wanted);
    return {now, Act::Nothing};
  }
  Step operator()(SessionReplaced) {
    now.state = SessionState::None;
    now.session = LifeCycle::Session::NotRunning;
    return {now, Act::Nothing};
  }
  Step operator()(SessionLost) { return (*this)(StateChanged{SessionState::LossPending}); }
  Step operator()(InstanceLossPending) { return finish(now, Ending::InstanceLost); }
  Step operator()(InstanceLost) { return finish(now, Ending::InstanceLost); }
  Step operator()(ExitWanted) {
    if (now.session == LifeCycle::Session::NotRunning) {
      now.exit = LifeCycle::Exit::Wanted;
      return finish(now, Ending::Wanted);
    }
    if (now.exit == LifeCycle::Exit::Requested) return {now, Act::Nothing};
    now.exit = LifeCycle::Exit::Requested;
    return {now, Act::RequestExit};
  }
};

}  // namespace

const char* name_of(SessionState state) {
  constexpr std::array names{"none",    "idle",     "ready",        "synchronized", "visible",
                             "focused", "stopping", "loss pending", "exiting"};
  return names[static_cast<std::size_t>(state)];
}

bool is_in_table(SessionState from, SessionState to) {
  using enum SessionState;
  if (to == LossPending) return from != LossPending && from != Exiting;
  switch (from) {
    case None:
      return to == Idle;
    case Idle:
      return to == Ready || to == Exiting;
    case Ready:
      return to == Synchronized;
    case Synchronized:
      return to == Visible || to == Stopping;
    case Visible:
      return to == Synchronized || to == Focused;
    case Focused:
      return to == Visible;
    case Stopping:
      return to == Idle;
    default:
      return false;
  }
}

Step after(LifeCycle before, const Event& event) {
  if (before.ending != Ending::None) return {before, Act::Finish};
  return std::visit(Apply{before}, event);
}

}  // namespace farshade::openxr
