#include "stereo/announce/announcer.h"

#include <avahi-client/publish.h>
#include <avahi-common/alternative.h>
#include <avahi-common/error.h>
#include <avahi-common/malloc.h>

#include <cstdint>
#include <set>
#include <utility>

#include "stereo/announce/announcement.h"
#include "stereo/announce/avahi.h"
#include "stereo/net/local_addresses.h"

namespace farshade {
namespace {

constexpr const char* kNoDaemon =
    "clients cannot find this server with --server auto, because avahi-daemon does not run on this machine: "
    "give them its address, or install avahi-daemon (--no-announce omits this line)";

avahi::TxtRecord txt_record() {
  AvahiStringList* list = nullptr;
  for (const std::string& text : announcement_txt()) list = avahi_string_list_add(list, text.c_str());
  return avahi::TxtRecord(list);
}

std::string next_name(const std::string& taken) {
  char* const other = avahi_alternative_service_name(taken.c_str());
  std::string name(other);
  avahi_free(other);
  return name;
}

}  // namespace

/// Its functions run in the constructor before the thread starts, and in the thread from then on.
struct Announcer::State {
  std::vector<Peer> listening;
  std::function<void(const std::string&)> note;
  avahi::ThreadedPoll poll{avahi_threaded_poll_new()};
  avahi::Client client{};            ///< destroyed before its poll
  AvahiEntryGroup* group = nullptr;  ///< of the client, which frees it
  std::string name{};
  bool told_trouble = false, told_success = false;

  void tell_once(bool& told, const std::string& sentence) {
    if (!std::exchange(told, true)) note(sentence);
  }
  void tell_trouble(int error) {
    tell_once(told_trouble,
              error == AVAHI_ERR_NO_DAEMON || error == AVAHI_ERR_DBUS_ERROR
                  ? std::string(kNoDaemon)
                  : std::string("the server is not announced on this network: ") + avahi_strerror(error));
  }

  void connect() {
    group = nullptr;
    client.reset();
    int error = 0;
    client.reset(avahi_client_new(avahi_threaded_poll_get(poll.get()), AVAHI_CLIENT_NO_FAIL,
                                  &State::client_changed, this, &error));
    if (!client) tell_trouble(error);
  }

  static void client_changed(AvahiClient* client, AvahiClientState changed, void* self) {
    State& state = *static_cast<State*>(self);
    if (changed == AVAHI_CLIENT_CONNECTING) state.tell_trouble(AVAHI_ERR_NO_DAEMON);
    if (changed == AVAHI_CLIENT_S_RUNNING) state.publish(*client);
    // The host's own name changes: the daemon runs again under the new one.
    if ((changed == AVAHI_CLIENT_S_COLLISION || changed == AVAHI_CLIENT_S_REGISTERING) && state.group)
      avahi_entry_group_reset(state.group);
    if (changed != AVAHI_CLIENT_FAILURE) return;
    // After a restart of the daemon, Avahi wants a new client. The old one may be freed here.
    if (avahi_client_errno(client) == AVAHI_ERR_DISCONNECTED)
      state.connect();
    else
      state.tell_trouble(avahi_client_errno(client));
  }

  void publish(AvahiClient& to) {
    if (name.empty()) name = avahi_client_get_host_name(&to);
    if (!group) group = avahi_entry_group_new(&to, &State::group_changed, this);
    if (!group) return tell_trouble(avahi_client_errno(&to));
    int error = AVAHI_ERR_COLLISION;
    for (int tries = 0; tries < 64 && error == AVAHI_ERR_COLLISION; ++tries) {
      if (tries > 0) name = next_name(name);
      avahi_entry_group_reset(group);
      error = add_all();
    }
    if (error == 0) error = avahi_entry_group_commit(group);
    if (error < 0) tell_trouble(error);
  }

  /// Adds the addresses to the group. A name has one port on an interface and in a family.
  int add_all() {
    const avahi::TxtRecord txt = txt_record();
    std::set<std::pair<AvahiIfIndex, AvahiProtocol>> added;
    for (const Peer& address : listening) {
      const std::uint32_t number = is_unspecified(address) ? 0 : interface_of(address);
      const AvahiIfIndex interface = number == 0 ? AVAHI_IF_UNSPEC : static_cast<AvahiIfIndex>(number);
      const AvahiProtocol protocol = is_v4(address)            ? AVAHI_PROTO_INET
                                     : is_unspecified(address) ? AVAHI_PROTO_UNSPEC
                                                               : AVAHI_PROTO_INET6;
      if (!added.emplace(interface, protocol).second) continue;
      const int error =
          avahi_entry_group_add_service_strlst(group, interface, protocol, {}, name.c_str(), kServiceType,
                                               nullptr, nullptr, address.port, txt.get());
      if (error != 0) return error;
    }
    return 0;
  }

  static void group_changed(AvahiEntryGroup* group, AvahiEntryGroupState changed, void* self) {
    State& state = *static_cast<State*>(self);
    AvahiClient* const client = avahi_entry_group_get_client(group);
    if (changed == AVAHI_ENTRY_GROUP_ESTABLISHED)
      state.tell_once(state.told_success, "announced on this network as '" + state.name +
                                              "': clients find this server with --server auto");
    if (changed == AVAHI_ENTRY_GROUP_FAILURE) state.tell_trouble(avahi_client_errno(client));
    if (changed != AVAHI_ENTRY_GROUP_COLLISION) return;
    state.name = next_name(state.name);
    state.publish(*client);
  }
};

Announcer::Announcer(std::vector<Peer> listening, std::function<void(const std::string&)> note)
    : state_(new State{.listening = std::move(listening), .note = std::move(note)}) {
  state_->connect();
  avahi_threaded_poll_start(state_->poll.get());
}

Announcer::~Announcer() {
  avahi_threaded_poll_stop(state_->poll.get());
}

Expected<void> can_announce() {
  const avahi::SimplePoll poll(avahi_simple_poll_new());
  const avahi::Client client(
      avahi_client_new(avahi_simple_poll_get(poll.get()), {}, nullptr, nullptr, nullptr));
  if (!client) return fail(Fault::Unavailable, "avahi-daemon does not run on this machine");
  return {};
}

}  // namespace farshade
