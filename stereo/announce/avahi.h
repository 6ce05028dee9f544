/// Owners of Avahi's objects.
#pragma once

#include <avahi-client/client.h>
#include <avahi-common/simple-watch.h>
#include <avahi-common/strlst.h>
#include <avahi-common/thread-watch.h>

#include <memory>

namespace farshade::avahi {

template <auto free>
struct Free {
  void operator()(auto* object) const { free(object); }
};

/// Frees its browsers, resolvers and groups, too. Destroy it before its poll.
using Client = std::unique_ptr<AvahiClient, Free<avahi_client_free>>;
using SimplePoll = std::unique_ptr<AvahiSimplePoll, Free<avahi_simple_poll_free>>;
using ThreadedPoll = std::unique_ptr<AvahiThreadedPoll, Free<avahi_threaded_poll_free>>;
using TxtRecord = std::unique_ptr<AvahiStringList, Free<avahi_string_list_free>>;

}  // namespace farshade::avahi
