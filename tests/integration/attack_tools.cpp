#include "tests/integration/attack_tools.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "stereo/base/check.h"
#include "stereo/net/udp.h"

namespace farshade {
namespace {

constexpr std::size_t kHeader_bytes = 7, kSession_at = 7, kCounter_at = 15;
constexpr std::uint8_t kHelloType = 1, kSealedType = 6;

std::uint8_t type_of(std::span<const std::byte> datagram) {
  return datagram.size() < kHeader_bytes ? std::uint8_t{0} : static_cast<std::uint8_t>(datagram[6]);
}

template <std::size_t N>
void randomise(std::array<std::uint8_t, N>& bytes, Random& random) {
  for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(random());
}

Bytes random_bytes(std::size_t size, Random& random) {
  Bytes bytes(size);
  for (std::byte& b : bytes) b = static_cast<std::byte>(random());
  return bytes;
}

/// Counts a datagram with a changed body: replayed if the server has seen its counter, otherwise forged.
void count_body(Counter counter, Tally& tally) {
  ++(counter == Counter::New ? tally.forged : tally.replayed);
}

std::unique_ptr<DatagramPort> listen_or_throw(const std::string& address) {
  Expected<std::unique_ptr<DatagramPort>> port = listen_udp(address);
  if (!port) throw std::runtime_error(port.error().what);
  return std::move(*port);
}

}  // namespace

Tally& Tally::operator+=(const Tally& other) {
  for (std::uint64_t Tally::*const count :
       {&Tally::truncated, &Tally::magic, &Tally::version, &Tally::type, &Tally::padding,
        &Tally::foreign_version, &Tally::hellos, &Tally::false_proofs, &Tally::unknown_session,
        &Tally::replayed, &Tally::forged, &Tally::sealed})
    this->*count += other.*count;
  return *this;
}

void flip_a_bit(Bytes& sealed, Counter counter, Random& random, Tally& tally) {
  const std::size_t bit = random() % (sealed.size() * 8), at = bit / 8;
  sealed[at] ^= std::byte{1} << bit % 8;
  if (at < 4)
    ++tally.magic;
  else if (at < 6)
    ++tally.version;
  else if (at < kSession_at)
    ++tally.type;
  else if (at < kCounter_at)
    ++tally.unknown_session;
  else if (at < kSealedHeader_bytes)
    ++tally.sealed;
  else
    count_body(counter, tally);
}

void cut(Bytes& sealed, Counter counter, Random& random, Tally& tally) {
  sealed.resize(random() % sealed.size());
  if (sealed.size() < kSealedHeader_bytes + kTag_bytes)
    ++tally.truncated;
  else
    count_body(counter, tally);
}

void drain(DatagramPort& port) {
  std::array<std::byte, kMaxDatagram_bytes> buffer;
  while (port.receive(buffer, Duration::zero())) {
  }
}

// ---- overheard

void Overheard::add(std::span<const std::byte> datagram) {
  const std::lock_guard lock(mutex_);
  std::vector<Bytes>& of = type_of(datagram) == kHelloType ? hellos_ : sealed_;
  if (of.size() < kMost)
    of.emplace_back(datagram.begin(), datagram.end());
  else
    of[heard_++ % kMost].assign(datagram.begin(), datagram.end());
}

Bytes Overheard::any(const std::vector<Bytes>& of, Random& random) const {
  const std::lock_guard lock(mutex_);
  return of.empty() ? Bytes() : of[random() % of.size()];
}

// ---- on the path

OnPath::OnPath(DatagramPort& inner, Overheard& overheard, std::uint64_t seed)
    : inner_(inner), elsewhere_(listen_or_throw("127.99.1.1:0")), overheard_(overheard), random_(seed) {}

bool OnPath::send(const Peer& to, std::span<const std::byte> bytes) {
  const bool is_sealed = type_of(bytes) == kSealedType;
  ++(is_sealed ? sealed_ : hellos_);
  if (is_sealed && attacking_) send_changed(to, bytes);
  const bool sent = inner_.send(to, bytes);
  if (is_sealed && attacking_) {
    inner_.send(to, bytes);
    ++tally_.replayed;
  }
  // After sending: the server must receive the original before a copy of it.
  overheard_.add(bytes);
  return sent;
}

void OnPath::send_changed(const Peer& to, std::span<const std::byte> sealed) {
  for (int copies = 0; copies < 4; ++copies) {
    Bytes changed(sealed.begin(), sealed.end());
    flip_a_bit(changed, Counter::New, random_, tally_);
    inner_.send(to, changed);
  }
  Bytes shorter(sealed.begin(), sealed.end());
  cut(shorter, Counter::New, random_, tally_);
  inner_.send(to, shorter);
  if (sealed_ % 4 == 0) {
    drain(*elsewhere_);
    elsewhere_->send(to, sealed);  // the first datagram with its counter, so the server accepts it
    ++tally_.replayed;
  }
}

// ---- strangers

Strangers::Strangers(const Peer& server, const KeyId& id, const Overheard& overheard, std::uint64_t seed)
    : server_(server), id_(id), overheard_(overheard), random_(seed) {
  for (int i = 0; i < 16; ++i) {
    Source source{.port = new_port(), .key = {}};
    if (!get_cookie(source)) throw std::runtime_error("the server sends no cookie");
    sources_.push_back(std::move(source));
  }
}

std::unique_ptr<DatagramPort> Strangers::new_port() {
  std::string address = "127";
  for (int i = 0; i < 3; ++i) address += "." + std::to_string(1 + below(254));
  ++addresses_;
  return listen_or_throw(address + ":0");
}

bool Strangers::get_cookie(Source& source) {
  randomise(source.key, random_);
  Bytes datagram;
  encode(Hello{.client = source.key, .key = id_}, datagram);
  ++tally_.hellos;
  source.port->send(server_, datagram);
  std::array<std::byte, kMaxDatagram_bytes> buffer;
  const auto answer = source.port->receive(buffer, std::chrono::minutes(1));
  if (!answer) return false;
  const Decoded<ServerEnvelope> envelope = open_server_envelope(answer->bytes);
  const Retry* const retry = envelope ? std::get_if<Retry>(&*envelope) : nullptr;
  if (retry == nullptr || retry->echo != echo_of(source.key)) return false;
  source.cookie = retry->cookie;
  return true;
}

bool Strangers::catch_up() {
  Source fresh{.port = new_port(), .key = {}};
  if (!get_cookie(fresh)) return false;
  for (const Source& source : sources_) take_answers(*source.port);
  Source& oldest = sources_[next_++ % sources_.size()];
  settle(*oldest.port);
  oldest = std::move(fresh);
  return true;
}

void Strangers::take_answers(DatagramPort& port) {
  std::array<std::byte, kMaxDatagram_bytes> buffer;
  while (const auto answer = port.receive(buffer, Duration::zero())) {
    const Decoded<ServerEnvelope> envelope = open_server_envelope(answer->bytes);
    const bool harmless = envelope && (std::holds_alternative<Retry>(*envelope) ||
                                       std::holds_alternative<OpenRefusal>(*envelope) ||
                                       std::holds_alternative<NoSession>(*envelope));
    if (!harmless) ++served_;
  }
}

void Strangers::settle(const DatagramPort& port) {
  const PortCounters counters = port.counters();
  bytes_sent_ += counters.sent_bytes;
  bytes_got_ += counters.received_bytes;
  if (counters.received_bytes > counters.sent_bytes) ++amplified_;
}

void Strangers::send_one() {
  const Source& source = sources_[below(sources_.size())];
  source.port->send(server_, make(source));
}

Bytes Strangers::make(const Source& source) {
  switch (below(4)) {
    case 0:
      return make_garbage();
    case 1:
      return make_hello(source);
    default:
      return make_sealed();
  }
}

Bytes Strangers::make_garbage() {
  Bytes bytes = random_bytes(below(kBaseDatagram_bytes + 1), random_);
  if (bytes.size() < kHeader_bytes) {
    ++tally_.truncated;
    return bytes;
  }
  const std::uint64_t kind = below(3);
  if (kind == 0) {
    bytes[0] = std::byte{0};
    ++tally_.magic;
    return bytes;
  }
  Bytes header;
  encode(Sealed{}, header);
  std::copy_n(header.begin(), kHeader_bytes, bytes.begin());
  if (kind == 1) {
    bytes[4] ^= std::byte{0x40};
    ++tally_.version;
  } else {
    bytes[6] = static_cast<std::byte>(kSealedType + 1 + below(200));
    ++tally_.type;
  }
  return bytes;
}

Bytes Strangers::make_hello(const Source& source) {
  Hello hello{.client = source.key, .key = id_, .cookie = source.cookie};
  if (below(2) == 0) randomise(hello.key, random_);
  randomise(hello.scene_hash, random_);
  randomise(hello.proof, random_);
  const std::uint64_t kind = below(6);
  if (kind == 0) hello.cookie = sources_[below(sources_.size())].cookie;
  if (kind == 1) hello.cookie = {};
  if (kind == 2) randomise(hello.cookie, random_);
  Bytes datagram;
  encode(hello, datagram);
  if (kind == 3) datagram = overheard_.any_hello(random_);  // its cookie belongs to another address
  if (kind == 4) {
    datagram[4] ^= static_cast<std::byte>(1 + below(255));
    ++tally_.foreign_version;
    return datagram;
  }
  if (kind == 5 && below(2) == 0) {
    if (below(2) == 0)
      datagram.back() = std::byte{1};
    else
      datagram.resize(kHeader_bytes + below(kBaseDatagram_bytes - kHeader_bytes));
    ++tally_.padding;
    return datagram;
  }
  if (kind == 5) ++tally_.false_proofs;
  ++tally_.hellos;
  return datagram;
}

Bytes Strangers::make_sealed() {
  Bytes sealed = overheard_.any_sealed(random_);
  switch (below(5)) {
    case 0:
      flip_a_bit(sealed, Counter::Repeated, random_, tally_);
      break;
    case 1:
      cut(sealed, Counter::Repeated, random_, tally_);
      break;
    case 2:
      ++tally_.replayed;
      break;
    case 3:  // forged: in the good client's session, with a newer counter
      for (std::size_t at = kCounter_at; at < sealed.size(); ++at)
        sealed[at] = static_cast<std::byte>(random_());
      ++tally_.forged;
      break;
    default:  // in a session that does not exist
      for (std::size_t at = kSession_at; at < sealed.size(); ++at)
        sealed[at] = static_cast<std::byte>(random_());
      ++tally_.unknown_session;
  }
  return sealed;
}

}  // namespace farshade
