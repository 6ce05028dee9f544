#include "vr_client/record/capture_writer.h"

#include <cerrno>
#include <system_error>

namespace farshade {
namespace {

Error why_not(const std::filesystem::path& path, int error) {
  if (error == EEXIST)
    return {Fault::Unavailable,
            path.string() + " exists: name another file for the capture, or remove that one"};
  return {error == ENOENT ? Fault::Missing : Fault::Unreadable,
          "cannot write " + path.string() + ": " + std::generic_category().message(error)};
}

}  // namespace

LinkListener CaptureWriter::listener() {
  return {.received =
              [this](std::span<const std::byte> message, Time arrived) {
                if (failed_) return;
                (frame_.request ? frame_.after : frame_.before)
                    .push_back({arrived, {message.begin(), message.end()}});
              },
          .sent =
              [this](const FrameRequest& request) {
                if (!failed_) frame_.request = CapturedRequest{clock_.now(), request};
              }};
}

Expected<void> CaptureWriter::may_create(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::exists(path, error)) return tl::unexpected(why_not(path, EEXIST));
  return {};
}

Expected<void> CaptureWriter::open(const std::filesystem::path& path, const CaptureHeader& header) {
  path_ = path;
  file_.reset(std::fopen(path.c_str(), "wbx"));
  if (!file_) return tl::unexpected(why_not(path, errno));
  append(header, pending_);
  if (!write()) return tl::unexpected(why_not(path, errno));
  return {};
}

/// Writes all pending bytes. False on failure; errno then holds the reason.
bool CaptureWriter::write() {
  bytes_ += pending_.size();
  const bool written = std::fwrite(pending_.data(), 1, pending_.size(), file_.get()) == pending_.size();
  pending_.clear();
  return written && std::fflush(file_.get()) == 0;
}

void CaptureWriter::watch(const FrameView& view, const PerEye<Image<Rgb8>>& shown) {
  if (has_ended()) return;
  frame_.input = {view.timing, view.shown.views, view.settings};
  for (const Side side : kSides) frame_.pictures[index_of(side)] = hash_of(shown[index_of(side)]);
  append(frame_, pending_);
  frame_ = {};
  if (write()) {
    ++frames_;
    return;
  }
  failed_ = why_not(path_, errno);
  failed_->what += "; the capture ends before frame " + std::to_string(view.shown.frame.value);
  file_.reset();
}

Expected<void> CaptureWriter::finish() {
  if (file_ && !failed_) {
    append(CaptureEnd{frames_}, pending_);
    if (!write()) failed_ = why_not(path_, errno);
  }
  file_.reset();
  if (failed_) return tl::unexpected(*failed_);
  return {};
}

}  // namespace farshade
