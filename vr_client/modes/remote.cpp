// Remote: the server draws both eyes and sends them as video; the client turns the newest picture to the pose
// it shows. What the picture does not cover is black.
#include "stereo/draw/turn_pass.h"
#include "vr_client/modes/video_stream.h"

namespace farshade {
namespace {

class Remote final : public Way {
 public:
  explicit Remote(const Session& session) : session_(session), stream_(session, Answer::Video) {}

  const TraceRequest* request(const Moment& moment) override { return stream_.request(moment); }
  void collect(const Moment& moment) override { stream_.collect(moment); }

  Seen draw(const Moment& moment) override {
    const VideoStream::Picture* const picture = stream_.picture();
    const StereoView& shown = moment.shown.views;
    if (picture == nullptr) {
      const PerEye<Image<Rgb8>> black{Image<Rgb8>(shown[0].size), Image<Rgb8>(shown[1].size)};
      return {.drawn = session_.renderer.show_turned(black, shown, shown),
              .as = ShownAs::Picture,
              .start_up = true,
              .black = {1.0, 1.0}};
    }
    const StereoView& from = picture->request.views;
    return {.drawn = session_.renderer.show_turned(picture->eyes, from, shown),
            .as = ShownAs::Picture,
            .newest = stream_.received(),
            .age = stream_.age(moment),
            .black = outside_share(from, shown),
            .decoding = stream_.decoding()};
  }

 private:
  const Session& session_;
  VideoStream stream_;
};

}  // namespace

std::unique_ptr<Way> make_remote(const Session& session) {
  return std::make_unique<Remote>(session);
}

}  // namespace farshade
