#include "rt_server/fetch/scene_sender.h"

#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>

#include "stereo/messages/fetch_messages.h"

namespace farshade {
namespace {

constexpr int kNiceness = 10;
constexpr std::size_t kPiece_bytes = 14 * kMaxContent_bytes;  ///< read, sealed and sent at once
constexpr Duration kLongestSleep = std::chrono::milliseconds(20);

void add(SealedStream& stream, const FetchAnswer& answer) {
  std::vector<std::byte> message;
  encode(answer, message, stream.version());
  stream.add(message);
}

Expected<void> refuse_fetch(SealedStream& stream, FetchRefusal why, const Waiting& waiting) {
  add(stream, why);
  if (auto sent = stream.flush(waiting); !sent) return sent;
  return fail(Fault::Unavailable, "refused");
}

}  // namespace

std::string counters_line(const SenderCounters& counters) {
  return fmt::format(
      "rt_server: scene fetch: {} connections, {} bytes sent; {} dropped, {} without a proved key, {} "
      "because "
      "too many fetch it",
      counters.accepted, counters.sent_bytes, counters.dropped, counters.unproved, counters.busy);
}

SceneSender::SceneSender(TcpListener listener, SceneToSend what, std::function<bool()> masks_are_sent,
                         const SenderLimits& limits)
    : listener_(std::move(listener)),
      what_(std::move(what)),
      masks_are_sent_(std::move(masks_are_sent)),
      limits_(limits),
      ring_(by_id(what_.ring)),
      rate_(limits.bytes_per_second),
      acceptor_([this](const std::stop_token& stop) { accept_all(stop); }) {}

SceneSender::~SceneSender() {
  acceptor_.request_stop();
  acceptor_.join();
  for (Connection& connection : connections_) connection.ended = true;
  // Their threads still walk through the list: it must stay whole until the last one has ended.
  for (Connection& connection : connections_) connection.thread.join();
}

SenderCounters SceneSender::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

void SceneSender::set_ring(const std::vector<SharedKey>& ring) {
  const std::lock_guard lock(mutex_);
  ring_ = by_id(ring);
  for (Connection& connection : connections_)
    if (connection.key && !ring_.contains(*connection.key)) connection.ended = true;
}

Waiting SceneSender::within(const Connection& connection, Duration span) {
  return {SteadyClock().now() + span, [&connection] { return connection.ended.load(); }};
}

void SceneSender::accept_all(const std::stop_token& stop) {
  setpriority(PRIO_PROCESS, 0, kNiceness);  // of this thread and those that it starts
  const auto stopped = [&stop] { return stop.stop_requested(); };
  Expected<ServedFiles> files = ServedFiles::open(what_.scene.parent_path(), what_.files);
  if (files) {
    offer_ = encode(SceneOffer{what_.lighting, files->files()});
    if (offer_.size() <= kMostOffer_bytes && decode_offer(offer_))
      files_ = std::move(*files);
    else
      spdlog::warn("clients cannot fetch the scene: its list of files or its lighting cannot be sent");
  } else {
    spdlog::warn("clients cannot fetch the scene: {}", files.error().what);
  }
  while (!stop.stop_requested()) {
    std::optional<TcpStream> stream =
        listener_.accept({SteadyClock().now() + std::chrono::seconds(1), stopped});
    bool started = false;
    {
      const std::lock_guard lock(mutex_);
      connections_.remove_if([](const Connection& connection) { return connection.done.load(); });
      if (stream) started = start(*std::move(stream));
    }
    if (started) std::this_thread::sleep_for(limits_.between_accepts);
  }
}

/// The caller holds the mutex.
bool SceneSender::start(TcpStream stream) {
  ++counters_.accepted;
  const Peer peer = stream.peer();
  std::size_t strangers = 0, of_network = 0;
  Connection* oldest = nullptr;
  for (Connection& connection : connections_) {
    if (connection.key || connection.ended) continue;
    ++strangers;
    if (is_of_one_network(connection.peer, peer)) ++of_network;
    if (oldest == nullptr) oldest = &connection;
  }
  const bool drops = of_network >= limits_.strangers_of_network;
  if (drops || strangers >= limits_.strangers) ++counters_.dropped;
  if (drops) return false;
  if (strangers >= limits_.strangers) oldest->ended = true;
  Connection& connection = connections_.emplace_back();
  connection.peer = peer;
  try {
    connection.thread =
        std::jthread([this, &connection, moved = std::make_shared<TcpStream>(std::move(stream))] {
          try {
            serve(connection, std::move(*moved));
          } catch (const std::exception& error) {
            spdlog::warn("a connection of the scene fetch ended: {}", error.what());
          }
          connection.done = true;
        });
  } catch (const std::system_error& error) {
    spdlog::warn("a connection of the scene fetch got no thread: {}", error.what());
    connections_.pop_back();
    return false;
  }
  return true;
}

bool SceneSender::promote(Connection& connection, const SharedKey& key) {
  const KeyId id = id_of(key);
  const std::lock_guard lock(mutex_);
  if (!ring_.contains(id)) return false;  // it was taken out of the ring meanwhile
  std::size_t all = 0, of_key = 0;
  for (const Connection& other : connections_) {
    if (!other.key || other.done) continue;
    ++all;
    if (*other.key == id) ++of_key;
  }
  if (all >= limits_.connections || of_key >= limits_.of_one_key) {
    ++counters_.busy;
    return false;
  }
  connection.key = id;
  spdlog::info("{} at {} asks for the scene", key.name, to_string(connection.peer));
  return true;
}

void SceneSender::serve(Connection& connection, TcpStream stream) {
  stream.let_others_pass();
  const Waiting first = within(connection, limits_.first_message);
  KeyRing ring;
  {
    const std::lock_guard lock(mutex_);
    ring = ring_;
  }
  Expected<SealedStream> connected =
      SealedStream::admit(std::move(stream), StreamPurpose::SceneFetch, ring, what_.served, first);
  bool is_proved = false;
  while (connected) {
    const auto message = connected->receive(is_proved ? within(connection, limits_.silence) : first);
    const auto request =
        message ? decode_fetch_request(*message, connected->version()) : refuse(WireRefusal::Truncated);
    if (!request) break;
    if (!is_proved && !promote(connection, ring.at(connected->key()))) {
      static_cast<void>(refuse_fetch(*connected, FetchRefusal::Busy, first));
      return;
    }
    is_proved = true;
    if (!answer(*connected, *request, connection)) break;
  }
  const std::lock_guard lock(mutex_);
  if (is_proved) return;
  ++counters_.unproved;
  if (connected || connected.error().fault != Fault::Mismatch) return;
  if (const auto line = refused_.failed(connected.error().what, SteadyClock().now()))
    spdlog::warn("{}", *line);
}

Expected<void> SceneSender::send_offer(SealedStream& stream, const Connection& connection) {
  for (std::span<const std::byte> left = offer_; !left.empty();) {
    const std::size_t size = std::min(left.size(), kMaxOfferPart_bytes);
    if (!wait_for_turn(connection, size)) return fail(Fault::Unavailable, "stopped");
    add(stream, OfferPart{left.size() > size ? OfferPart::More::Yes : OfferPart::More::No, left.first(size)});
    left = left.subspan(size);
    if (stream.queued_bytes() < kPiece_bytes && !left.empty()) continue;
    if (auto sent = stream.flush(within(connection, limits_.silence)); !sent) return sent;
  }
  return {};
}

Expected<void> SceneSender::answer(SealedStream& stream, const FetchRequest& request,
                                   const Connection& connection) {
  const Waiting soon = within(connection, limits_.silence);
  if (!files_) return refuse_fetch(stream, FetchRefusal::Unreadable, soon);
  const auto* range = std::get_if<ContentRequest>(&request);
  if (range == nullptr) return send_offer(stream, connection);
  if (range->end > total_bytes(files_->files())) return fail(Fault::OutOfRange, "a range beyond the content");
  std::vector<std::byte> piece;
  for (std::uint64_t at = range->begin; at < range->end; at += piece.size()) {
    piece.resize(std::min<std::uint64_t>(kPiece_bytes, range->end - at));
    if (const Expected<void> read = files_->read(at, piece); !read) {
      spdlog::warn("the scene is not sent: {}", read.error().what);
      return refuse_fetch(stream, FetchRefusal::Changed, soon);
    }
    if (!wait_for_turn(connection, piece.size())) return fail(Fault::Unavailable, "stopped");
    for (std::size_t done = 0; done < piece.size(); done += kMaxContent_bytes)
      add(stream, Content{at + done,
                          std::span(piece).subspan(done, std::min(kMaxContent_bytes, piece.size() - done))});
    if (auto sent = stream.flush(within(connection, limits_.silence)); !sent) return sent;
  }
  return {};
}

bool SceneSender::wait_for_turn(const Connection& connection, std::size_t bytes) {
  while (!connection.ended) {
    const auto masks = masks_are_sent_() ? SendRate::Masks::Sent : SendRate::Masks::Idle;
    Duration wait;
    {
      const std::lock_guard lock(mutex_);
      wait = rate_.take(bytes, masks, SteadyClock().now());
      if (wait == Duration::zero()) counters_.sent_bytes += bytes;
    }
    if (wait == Duration::zero()) return true;
    std::this_thread::sleep_for(std::min(wait, kLongestSleep));
  }
  return false;
}

}  // namespace farshade
