/// PartialRequest: lets a request ask only for the blocks that the newest mask leaves unknown
/// (docs/partial-requests.md).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "stereo/answers/assembler.h"
#include "stereo/codec/ask_coder.h"
#include "stereo/draw/renderer.h"
#include "stereo/link/server_connection.h"

namespace farshade {

class PartialRequest {
 public:
  /// A request that would ask for more than this part of the masks asks for whole views: the set would cost
  /// more than it saves (docs/partial-requests.md). Three quarters would differ only after a cut or a jump of
  /// the head.
  static constexpr double kMostRequested = 0.5;

  /// If requests would ask for more again and again, at most so many in a row do not reproject anything.
  static constexpr std::uint32_t kMostSkipped = 63;

  explicit PartialRequest(Renderer& renderer) : renderer_(renderer) {}

  /// Begins to reproject the mask of `base` to the views of `request`, whose record will get `slot`. It does
  /// not begin if there is no base and the lenses hide nothing, or nothing can be reprojected: then the
  /// request asks for whole views. `hidden` has no surface (Renderer::keep_depth), and a set of blocks has
  /// only those with a surface.
  void begin(const FrameRequest& request, std::size_t slot, const RequestRecord* base,
             const PerEye<HiddenArea>& hidden = {});
  /// Sets what the request asks for. Waits for what has begun, if it has. `request` is that of `begin`.
  void complete(FrameRequest& request);
  /// This frame makes no request, or one for whole views that does not look at earlier masks.
  void skip();

  /// What goes with the request, once it is complete. Valid until the next begin or skip.
  [[nodiscard]] RequestParts parts() const;

  /// It has begun. Then the depth of the requested views is drawn, too.
  [[nodiscard]] bool has_begun() const { return has_begun_; }

 private:
  void refresh(const FrameRequest& request);
  void ask_for_surfaces();
  void pack(const FrameRequest& request);

  Renderer& renderer_;
  RequestReprojection reprojected_;
  bool has_begun_ = false, has_lenses_ = false;
  std::optional<Time> base_time_;  ///< when the mask that is reprojected was shown; empty: there is none
  AskPacker packer_;
  std::vector<std::vector<std::byte>> messages_;
  std::size_t messages_used_ = 0;   ///< 0: whole views are asked for
  std::uint32_t to_skip_ = 0;       ///< requests that still do not reproject anything
  std::uint32_t last_skipped_ = 0;  ///< requests in a row, after the last that would have asked for too much
};

}  // namespace farshade
