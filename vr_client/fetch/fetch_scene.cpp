#include "vr_client/fetch/fetch_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "stereo/base/user_folders.h"
#include "stereo/messages/fetch_messages.h"
#include "stereo/net/sealed_stream.h"
#include "vr_client/fetch/scene_cache.h"

namespace farshade {
namespace {

constexpr int kMostOffers = 3;  ///< of different files, in one fetch

Time now() {
  return SteadyClock().now();
}

/// Waits before another try, unless the caller wants to stop.
void pause(const FetchPlan& plan) {
  const Time until = now() + plan.retry_pause;
  while (now() < until && !plan.stopped()) std::this_thread::sleep_for(std::min(kStopPoll, plan.retry_pause));
}

/// Whether another connection may help.
bool can_go_on(const Error& error) {
  return error.fault == Fault::Missing;
}

Error explained(FetchRefusal refusal) {
  switch (refusal) {
    case FetchRefusal::Busy:
      return {Fault::Missing, "the server sends its scene to as many clients as it may: try again later"};
    case FetchRefusal::Changed:
      return {Fault::Mismatch,
              "a file of the scene has changed on the server since its start: restart the server"};
    case FetchRefusal::Unreadable:
      break;
  }
  return {Fault::Unreadable,
          "the server cannot send its scene (its log says why): copy the files and give --scene"};
}

/// The next answer. Malformed if it is none, or a refusal's error.
Expected<FetchAnswer> receive_answer(SealedStream& stream, const Waiting& waiting) {
  const auto message = stream.receive(waiting);
  if (!message) return tl::unexpected(message.error());
  const Decoded<FetchAnswer> answer = decode_fetch_answer(*message);
  if (!answer) return fail(Fault::Malformed, "the server does not follow the protocol");
  if (const auto* refusal = std::get_if<FetchRefusal>(&*answer)) return tl::unexpected(explained(*refusal));
  return *answer;
}

Expected<void> send_request(SealedStream& stream, const FetchRequest& request, const Waiting& waiting) {
  std::vector<std::byte> message;
  encode(request, message);
  stream.add(message);
  return stream.flush(waiting);
}

struct OpenedFetch {
  SealedStream stream;
  ReceivedOffer received;
};

/// Asks for the offer over a new connection.
Expected<OpenedFetch> ask_over(TcpStream tcp, const FetchPlan& plan, const Waiting& waiting) {
  Expected<SealedStream> stream =
      SealedStream::connect(std::move(tcp), StreamPurpose::SceneFetch, plan.key, waiting);
  if (!stream) return tl::unexpected(stream.error());
  if (auto sent = send_request(*stream, OfferRequest{}, waiting); !sent) return tl::unexpected(sent.error());
  std::vector<std::byte> bytes;
  for (auto more = OfferPart::More::Yes; more == OfferPart::More::Yes;) {
    const Expected<FetchAnswer> answer = receive_answer(*stream, waiting);
    if (!answer) return tl::unexpected(answer.error());
    const auto* part = std::get_if<OfferPart>(&*answer);
    if (part == nullptr || bytes.size() + part->bytes.size() > kMostOffer_bytes)
      return fail(Fault::Malformed, "the server's offer of its scene cannot be read");
    bytes.insert(bytes.end(), part->bytes.begin(), part->bytes.end());
    more = part->more;
  }
  Expected<SceneOffer> offer = decode_offer(bytes);
  if (!offer) return tl::unexpected(offer.error());
  const ContentHash hash = stream->served().scene_hash;
  return OpenedFetch{*std::move(stream), {*std::move(offer), hash}};
}

/// Connects and asks for the offer.
Expected<OpenedFetch> open_fetch(const FetchPlan& plan, const Waiting& waiting) {
  return connect_tcp(plan.servers, waiting).and_then([&](TcpStream&& tcp) {
    return ask_over(std::move(tcp), plan, waiting);
  });
}

/// Fails a fetch that brings almost nothing.
class Pace {
 public:
  explicit Pace(const FetchPlan& plan) : plan_(plan) { begin(); }

  void add(std::size_t bytes) {
    if ((bytes_ += bytes) >= plan_.least_bytes) begin();
  }
  [[nodiscard]] Waiting waiting() const { return {until_, plan_.stopped}; }
  /// For one answer: a connection that has fallen silent is given up while there is time for another one.
  [[nodiscard]] Waiting for_answer() const {
    return {std::min(until_, now() + plan_.patience / 2), plan_.stopped};
  }
  [[nodiscard]] bool is_over() const { return now() >= until_ || plan_.stopped(); }

 private:
  void begin() {
    bytes_ = 0;
    until_ = now() + plan_.patience;
  }
  const FetchPlan& plan_;
  std::uint64_t bytes_ = 0;
  Time until_{};
};

/// Asks for the first missing range and stores it.
Expected<void> fetch_range(const FetchPlan& plan, SealedStream& stream, SceneCache& cache, std::uint64_t all,
                           Pace& pace) {
  const ContentRange range = cache.missing().value();
  if (auto sent = send_request(stream, ContentRequest{range.begin, range.end}, pace.waiting()); !sent)
    return sent;
  for (std::uint64_t at = range.begin; at < range.end;) {
    const Expected<FetchAnswer> answer = receive_answer(stream, pace.for_answer());
    if (!answer) return tl::unexpected(answer.error());
    const auto* content = std::get_if<Content>(&*answer);
    if (content == nullptr || content->begin != at || content->bytes.size() > range.end - at)
      return fail(Fault::Malformed, "the server sends other bytes than it was asked for");
    if (auto written = cache.append(content->bytes); !written) return written;
    at += content->bytes.size();
    pace.add(content->bytes.size());
    plan.progress(all - cache.missing_bytes(), all);
    // A file that was resumed had a wrong hash and is missing again: the rest of this answer is of no use.
    if (at < range.end && cache.missing()->begin != at)
      return fail(Fault::Missing, "a file that was fetched in part is fetched again");
  }
  return {};
}

Error stopped_error(const FetchPlan& plan, const SceneCache& cache, std::uint64_t all) {
  return {Fault::Unavailable,
          fmt::format(
              "stopped: {:.1f} of {:.1f} MB of the scene are kept in {}; the next start goes on from there",
              static_cast<double>(all - cache.missing_bytes()) * 1e-6, static_cast<double>(all) * 1e-6,
              plan.cache.string())};
}

/// Whether two offers describe the same lit scene.
bool are_same(const ReceivedOffer& a, const ReceivedOffer& b) {
  return a.hash == b.hash && a.offer.files == b.offer.files;
}

/// Fetches what is missing, with as many connections as it takes. False: the server has another scene by now.
Expected<bool> fill(const FetchPlan& plan, OpenedFetch opened, SceneCache& cache) {
  const std::uint64_t all = total_bytes(opened.received.offer.files);
  Pace pace(plan);
  std::optional<SealedStream> stream = std::move(opened.stream);
  while (cache.missing()) {
    Expected<void> done;
    if (!stream) {
      Expected<OpenedFetch> again = open_fetch(plan, pace.waiting());
      if (again && !are_same(again->received, opened.received)) return false;
      if (again) stream = std::move(again->stream);
      if (!again) done = tl::unexpected(again.error());
    }
    if (stream) done = fetch_range(plan, *stream, cache, all, pace);
    if (done) continue;
    stream.reset();
    if (plan.stopped()) return tl::unexpected(stopped_error(plan, cache, all));
    if (!can_go_on(done.error())) return tl::unexpected(done.error());
    if (pace.is_over())
      return fail(Fault::Missing,
                  fmt::format("the server sent less than {} bytes of its scene in {:g} s ({})",
                              plan.least_bytes, seconds_of(plan.patience), done.error().what));
    pause(plan);
  }
  return true;
}

Expected<SceneCache> open_cache(const FetchPlan& plan, const SceneOffer& offer) {
  bool told = false;
  return SceneCache::open(plan.cache, offer.files, [&] {
    if (!told) plan.note("another client is fetching the same scene; waiting for it");
    told = true;
    return !plan.stopped();
  });
}

/// Connects for the first time. Tries again while the server is busy: it says so, or closes the connection at
/// once because many of this address wait there. Without a server it fails at once.
Expected<OpenedFetch> open_first(const FetchPlan& plan) {
  const Waiting waiting{now() + plan.patience, plan.stopped};
  for (bool told = false;; told = true) {
    Expected<TcpStream> tcp = connect_tcp(plan.servers, waiting);
    if (!tcp) return tl::unexpected(tcp.error());
    Expected<OpenedFetch> opened = ask_over(*std::move(tcp), plan, waiting);
    if (opened || !can_go_on(opened.error())) return opened;
    if (plan.stopped() || now() + plan.retry_pause >= waiting.until) return opened;
    if (!told)
      plan.note(fmt::format("the server does not send its scene yet ({}); trying again for {:g} s",
                            opened.error().what, seconds_of(plan.patience)));
    pause(plan);
  }
}

}  // namespace

Expected<ReceivedOffer> ask_offer(const FetchPlan& plan) {
  return open_first(plan).map([](OpenedFetch&& opened) { return std::move(opened.received); });
}

Expected<FetchedScene> fetch_scene(const FetchPlan& plan) {
  for (int tries = 0; tries < kMostOffers; ++tries) {
    Expected<OpenedFetch> opened = open_first(plan);
    if (!opened) return tl::unexpected(opened.error());
    const ReceivedOffer received = opened->received;
    Expected<SceneCache> cache = open_cache(plan, received.offer);
    if (!cache) return tl::unexpected(cache.error());
    const std::uint64_t missing = cache->missing_bytes();
    const std::uint64_t all = total_bytes(received.offer.files);
    if (plan.stopped()) return tl::unexpected(stopped_error(plan, *cache, all));
    const Expected<bool> filled = fill(plan, *std::move(opened), *cache);
    if (!filled) return tl::unexpected(filled.error());
    if (plan.stopped()) return tl::unexpected(stopped_error(plan, *cache, all));
    if (*filled) return FetchedScene{cache->scene(), received.offer.lighting, received.hash, missing};
    plan.note("the server has another scene now: fetching that");
  }
  return fail(Fault::Unavailable, "the scene changes on the server again and again");
}

std::filesystem::path scene_cache_folder() {
  return cache_folder() / "scenes";
}

}  // namespace farshade
