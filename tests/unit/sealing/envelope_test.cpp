#include "stereo/sealing/envelope.h"

#include <gtest/gtest.h>

#include "tests/unit/messages/samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

const Bytes kSealedBytes(20, std::byte{0x5a});

Sealed sealed_sample() {
  return {SessionId{0x0807060504030201}, 0x334455667788, kSealedBytes, 0x1122};
}

std::vector<Bytes> to_server() {
  return {enveloped(hello()), enveloped(sealed_sample())};
}
std::vector<Bytes> to_client() {
  return {enveloped(retry()), enveloped(open_refusal()), enveloped(accept_sample(kSealedBytes)),
          enveloped(no_session()), enveloped(sealed_sample())};
}

Bytes cut(const Bytes& whole, std::size_t size) {
  return {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)};  // its own allocation
}

Bytes flipped(Bytes bytes, std::size_t bit) {
  bytes[bit / 8] ^= std::byte{1} << bit % 8;
  return bytes;
}

TEST(Envelopes, ComeBackAsTheyWere) {
  EXPECT_EQ(std::get<Hello>(*open_client_envelope(enveloped(hello()))), hello());
  EXPECT_EQ(std::get<Retry>(*open_server_envelope(enveloped(retry()))), retry());
  EXPECT_EQ(std::get<OpenRefusal>(*open_server_envelope(enveloped(open_refusal()))), open_refusal());
  EXPECT_EQ(std::get<NoSession>(*open_server_envelope(enveloped(no_session()))), no_session());

  const Bytes accept_bytes = enveloped(accept_sample(kSealedBytes));
  const auto accept = std::get<Accept>(*open_server_envelope(accept_bytes));
  EXPECT_EQ(accept.echo, accept_sample({}).echo);
  EXPECT_EQ(accept.session, accept_sample({}).session);
  EXPECT_EQ(accept.server, accept_sample({}).server);
  EXPECT_EQ(Bytes(accept.sealed.begin(), accept.sealed.end()), kSealedBytes);
  EXPECT_EQ(accept.sealed.data(), accept_bytes.data() + kAcceptHeader_bytes);

  const Bytes bytes = enveloped(sealed_sample());
  for (const Sealed& sealed :
       {std::get<Sealed>(*open_client_envelope(bytes)), std::get<Sealed>(*open_server_envelope(bytes))}) {
    EXPECT_EQ(sealed.session, sealed_sample().session);
    EXPECT_EQ(sealed.counter, sealed_sample().counter);
    EXPECT_EQ(sealed.epoch, sealed_sample().epoch);
    EXPECT_EQ(Bytes(sealed.sealed.begin(), sealed.sealed.end()), kSealedBytes);
    EXPECT_EQ(sealed.sealed.data(), bytes.data() + kSealedHeader_bytes);
  }
}

TEST(Envelopes, HelloIsAsLongAsADatagramMayBe) {
  EXPECT_EQ(enveloped(hello()).size(), kBaseDatagram_bytes);
}

TEST(Envelopes, NoAnswerInTheOpenIsLongerThanWhatItAnswers) {
  for (const Bytes& answer : {enveloped(retry()), enveloped(open_refusal())})
    EXPECT_LE(answer.size(), enveloped(hello()).size());
  const Sealed shortest{SessionId{7}, 0, std::span(kSealedBytes).first(kTag_bytes)};
  EXPECT_LE(enveloped(no_session()).size(), enveloped(shortest).size());
}

TEST(Envelopes, RefuseEveryTruncation) {
  for (const Bytes& whole : to_server())
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const auto envelope = open_client_envelope(cut(whole, size));
      if (envelope) {  // the bytes of a tag may have any value
        EXPECT_TRUE(std::holds_alternative<Sealed>(*envelope) && size >= kSealedHeader_bytes + kTag_bytes);
        continue;
      }
      const bool padded = size >= 7 && whole.size() == kBaseDatagram_bytes;
      EXPECT_EQ(envelope.error(), padded ? WireRefusal::Padding : WireRefusal::Truncated) << size;
    }
  for (const Bytes& whole : to_client())
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const auto envelope = open_server_envelope(cut(whole, size));
      if (!envelope) {
        EXPECT_EQ(envelope.error(), WireRefusal::Truncated) << size << " of " << whole.size();
        continue;
      }
      const bool is_accept = std::holds_alternative<Accept>(*envelope);
      EXPECT_TRUE(is_accept || std::holds_alternative<Sealed>(*envelope));
      EXPECT_GE(size, (is_accept ? kAcceptHeader_bytes : kSealedHeader_bytes) + kTag_bytes);
    }
}

TEST(Envelopes, RefuseWhatFollowsTheLastField) {
  for (Bytes bytes : {enveloped(retry()), enveloped(open_refusal()), enveloped(no_session())}) {
    bytes.push_back(std::byte{0});
    EXPECT_EQ(open_server_envelope(bytes).error(), WireRefusal::TrailingBytes);
  }
}

/// An envelope that is accepted keeps all information: encoding it again gives the same bytes.
TEST(Envelopes, EveryFlippedBitIsRefusedOrMeansWhatItSays) {
  const auto for_each_flip = [](const std::vector<Bytes>& datagrams, const auto& look_at) {
    for (const Bytes& whole : datagrams)
      for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) look_at(flipped(whole, bit));
  };
  for_each_flip(to_server(), [](const Bytes& bytes) {
    const auto envelope = open_client_envelope(bytes);
    if (!envelope) return;
    if (const auto* foreign = std::get_if<ForeignHello>(&*envelope))
      EXPECT_FALSE(is_spoken(foreign->version));
    else if (const auto* sealed = std::get_if<Sealed>(&*envelope))
      EXPECT_EQ(enveloped(*sealed), bytes);
    else
      EXPECT_EQ(enveloped(std::get<Hello>(*envelope)), bytes);
  });
  for_each_flip(to_client(), [](const Bytes& bytes) {
    const auto envelope = open_server_envelope(bytes);
    if (!envelope) return;
    EXPECT_EQ(std::visit([](const auto& e) { return enveloped(e); }, *envelope), bytes);
  });
}

TEST(Envelopes, EachSideRefusesWhatOnlyTheOtherSays) {
  EXPECT_EQ(open_server_envelope(enveloped(hello())).error(), WireRefusal::Type);
  for (const Bytes& bytes : {enveloped(retry()), enveloped(open_refusal()),
                             enveloped(accept_sample(kSealedBytes)), enveloped(no_session())})
    EXPECT_EQ(open_client_envelope(bytes).error(), WireRefusal::Type);
}

TEST(HelloEnvelope, IsPaddedWithZerosToItsLastByte) {
  for (const std::size_t at : {std::size_t{127}, std::size_t{500}, kBaseDatagram_bytes - 1}) {
    Bytes bytes = enveloped(hello());
    bytes[at] = std::byte{1};
    EXPECT_EQ(open_client_envelope(bytes).error(), WireRefusal::Padding) << at;
  }
}

TEST(HelloEnvelope, OfAnotherVersionIsKnownByVersionAndEcho) {
  Bytes bytes = enveloped(hello());
  bytes[4] ^= std::byte{1};
  bytes[kBaseDatagram_bytes - 1] = std::byte{0xff};  // the bytes after the echo are not checked
  const auto foreign = std::get<ForeignHello>(*open_client_envelope(bytes));
  EXPECT_EQ(foreign.version, kProtocolVersion ^ 1);
  EXPECT_EQ(foreign.echo, retry().echo);
  bytes.pop_back();  // a short hello gets no answer: the answer could be longer than the hello
  EXPECT_EQ(open_client_envelope(bytes).error(), WireRefusal::Padding);
}

TEST(OpenRefusalEnvelope, OfAnotherVersionIsUnderstood) {
  OpenRefusal later = open_refusal();
  later.version = kProtocolVersion ^ 1;
  later.reason = RefusalReason::VersionMismatch;
  EXPECT_EQ(std::get<OpenRefusal>(*open_server_envelope(enveloped(later))), later);
}

}  // namespace
}  // namespace farshade
