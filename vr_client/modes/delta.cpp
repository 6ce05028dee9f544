// Delta: the client draws its own picture without shadows and adds what the server says they change (delta
// encoding of Cuervo et al., "Kahawai: High-Quality Mobile Gaming Using GPU Offload", MobiSys 2015), turned
// to the pose shown. Where the server's picture does not reach, the client's own shows, without shadows.
#include "stereo/draw/turn_pass.h"
#include "vr_client/modes/video_stream.h"

namespace farshade {
namespace {

class Delta final : public Way {
 public:
  explicit Delta(const Session& session) : session_(session), stream_(session, Answer::Difference) {}

  const TraceRequest* request(const Moment& moment) override { return stream_.request(moment); }
  void collect(const Moment& moment) override { stream_.collect(moment); }

  Seen draw(const Moment& moment) override {
    const ShownFrame frame{.views = moment.shown.views, .state = moment.state, .masks = {}, .carry_over = {}};
    const VideoStream::Picture* const picture = stream_.picture();
    if (picture == nullptr)
      return {.drawn = session_.renderer.draw(frame), .as = ShownAs::Picture, .start_up = true};
    const StereoView& from = picture->request.views;
    return {.drawn = session_.renderer.draw_with_difference(frame, picture->eyes, from),
            .as = ShownAs::Picture,
            .newest = stream_.received(),
            .age = stream_.age(moment),
            .black = outside_share(from, moment.shown.views),
            .decoding = stream_.decoding()};
  }

 private:
  const Session& session_;
  VideoStream stream_;
};

}  // namespace

std::unique_ptr<Way> make_delta(const Session& session) {
  return std::make_unique<Delta>(session);
}

}  // namespace farshade
