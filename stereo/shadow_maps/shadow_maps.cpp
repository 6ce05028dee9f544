#include "stereo/shadow_maps/shadow_maps.h"

namespace farshade {
namespace {

using Layout = vk::ImageLayout;
using Kind = LayerUpdate::Kind;

static_assert((kMaxLights + 1) * sizeof(gpu::ShadowMapData) <= gpu::kUniformRange_bytes);

constexpr auto kDepthTarget = vk::ImageUsageFlagBits::eDepthStencilAttachment;

/// `layers` can be made for `settings`.
MapLayers checked_layers(const Scene& scene, const ShadowMapSettings& settings) {
  check(shadow_map_bytes(scene, settings).has_value(), "shadow_map_bytes accepts the settings");
  return map_layers(scene, settings);
}

vk::ImageUsageFlags map_usage(const MapLayers& layers) {
  const vk::ImageUsageFlags usage = kDepthTarget | vk::ImageUsageFlagBits::eSampled;
  return layers.kept > 0 ? usage | vk::ImageUsageFlagBits::eTransferDst : usage;
}

std::vector<Caster> casters_of(const Scene& scene, const SceneBuffers& buffers) {
  std::vector<Caster> casters;
  for (const Instance& instance : scene.instances)
    casters.push_back({buffers.meshes[instance.mesh].center, instance.casts && can_move(scene, instance)});
  return casters;
}

std::vector<bool> can_keep(const MapLayers& layers) {
  std::vector<bool> result;
  for (std::uint32_t layer = 0; layer < layers.count; ++layer)
    result.push_back(layers.kept_pair[layer / 2].has_value());
  return result;
}

const std::vector<gpu::BindingKind> kMapSet{
    {vk::DescriptorType::eCombinedImageSampler, vk::ShaderStageFlagBits::eCompute},
    {vk::DescriptorType::eUniformBuffer, vk::ShaderStageFlagBits::eCompute}};

}  // namespace

ShadowMaps::DepthLayers ShadowMaps::make_layers(const gpu::Device& device, std::uint32_t count,
                                                std::uint32_t side_px, vk::ImageUsageFlags usage,
                                                const std::string& name) {
  DepthLayers result{.image = gpu::make_image(device,
                                              {.size = {side_px, side_px},
                                               .layers = count,
                                               .format = kDepthFormat,
                                               .usage = usage,
                                               .use = gpu::Use::ShadowMaps},
                                              name),
                     .pairs = {}};
  for (std::uint32_t first = 0; first < count; first += 2)
    result.pairs.push_back(gpu::view_layers(device, result.image, {first, 2}));
  return result;
}

ShadowMaps::ShadowMaps(gpu::FramesInFlight& frames, const Scene& scene, const DrawPlan& plan,
                       const SceneBuffers& buffers, const gpu::UploadBuffer& frame,
                       const ShadowMapSettings& settings)
    : scene_(scene),
      buffers_(buffers),
      settings_(settings),
      layers_(checked_layers(scene, settings)),
      maps_(make_layers(frames.device(), layers_.count, settings.side_px, map_usage(layers_), "shadow maps")),
      map_data_(gpu::make_upload_buffer(frames, (scene.lights.size() + 1) * sizeof(gpu::ShadowMapData),
                                        vk::BufferUsageFlagBits::eUniformBuffer, "shadow map views",
                                        gpu::Use::ShadowMaps)),
      nearest_(frames.device().logical.createSampler({})),
      bindings_(gpu::make_bindings(frames.device(), kMapSet, "shadow maps")),
      pass_(frames, scene, plan, buffers, frame, Outputs::Casters, layers_.count / 2),
      updates_(casters_of(scene, buffers), can_keep(layers_), settings) {
  if (layers_.kept > 0)
    kept_ = make_layers(frames.device(), layers_.kept, settings.side_px,
                        kDepthTarget | vk::ImageUsageFlagBits::eTransferSrc, "kept shadow depth");
  gpu::run_now(frames.device(), [&](const vk::raii::CommandBuffer& commands) {
    gpu::transition(commands, maps_.image, Layout::eUndefined, Layout::eShaderReadOnlyOptimal);
    if (kept_) gpu::transition(commands, kept_->image, Layout::eUndefined, Layout::eTransferSrcOptimal);
  });
  gpu::bind_image(frames.device(), bindings_, 0,
                  {*maps_.image.view, Layout::eShaderReadOnlyOptimal, *nearest_});
  gpu::bind_buffer(frames.device(), bindings_, 1, map_data_.buffer());
}

/// Corners that do not change are found once.
void ShadowMaps::find_corners(const SceneState& state) {
  const auto add = [&](bool moves) {
    for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
      const Instance& instance = scene_.instances[i];
      if (!instance.casts || can_move(scene_, instance) != moves) continue;
      const glm::dvec3& center = buffers_.meshes[scene_.instances[i].mesh].center;
      for (int corner = 0; corner < 8; ++corner)
        corners_.push_back(
            state.stage_from_object[i](Point<Object>{center + pass_.box_of(i).corner(corner)}));
    }
  };
  if (corners_.empty()) {
    add(false);
    fixed_corners_ = corners_.size();
  }
  corners_.resize(fixed_corners_);
  add(true);
}

std::vector<CasterPlace> ShadowMaps::places(const SceneState& state) const {
  std::vector<CasterPlace> result;
  for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
    const DeformedVertices::Place* deformed = pass_.deformed().of(i);
    result.push_back({state.stage_from_object[i], pass_.box_of(i),
                      deformed != nullptr ? deformed->shape : std::uint64_t{0}});
  }
  return result;
}

void ShadowMaps::prepare(const StereoView& shown, const SceneState& state) {
  const std::vector<Light>& lights = state.light_set.lights;
  check_eq(lights.size(), scene_.lights.size(), "lights of the scene and of its state");
  pass_.deform(state);
  find_corners(state);
  ShadowMapViews views = shadow_map_views(lights, corners_, settings_);
  for (std::size_t i = 0; i < lights.size(); ++i) map_data_.write(i, shadow_map_data(shown, views.lights[i]));
  views.layer_clip.resize(layers_.count, clip_from_stage({}));
  add_passes(updates_.next(views.layer_clip, places(state)), views.layer_clip);
  if (due()) pass_.prepare(passes_, {settings_.side_px, settings_.side_px}, state);
}

void ShadowMaps::add_passes(const std::vector<LayerUpdate>& updates, std::span<const glm::dmat4> layer_clip) {
  passes_.clear(), copies_.clear();
  drawn_ = {};
  const auto add = [&](const auto& casters_of) {
    for (std::size_t pair = 0; pair < layers_.count / 2; ++pair) {
      const std::size_t first = 2 * pair;
      const PerEye<Casters> casters{casters_of(updates[first]), casters_of(updates[first + 1])};
      if (casters[0] == Casters::None && casters[1] == Casters::None) continue;
      passes_.push_back({pair, {layer_clip[first], layer_clip[first + 1]}, casters});
    }
  };
  add([](const LayerUpdate& update) { return update.keeps ? Casters::Fixed : Casters::None; });
  kept_passes_ = passes_.size();
  add([](const LayerUpdate& update) {
    return update.kind == Kind::Redraw    ? Casters::All
           : update.kind == Kind::Restore ? Casters::Moving
                                          : Casters::None;
  });
  for (std::uint32_t layer = 0; layer < layers_.count; ++layer) {
    const LayerUpdate& update = updates[layer];
    drawn_.drawn += update.kind == Kind::Redraw || update.keeps ? 1 : 0;
    drawn_.restored += update.kind == Kind::Restore && !update.keeps ? 1 : 0;
    if (update.kind == Kind::Restore && !update.lost.empty()) add_copy(layer, update.lost);
  }
}

void ShadowMaps::add_copy(std::uint32_t layer, const TexelRect& lost) {
  const vk::Offset3D at{lost.low.x, lost.low.y, 0};
  const glm::uvec2 size(lost.high - lost.low);
  const std::uint32_t kept_layer = 2 * layers_.kept_pair[layer / 2].value() + layer % 2;
  copies_.push_back({.srcSubresource = {vk::ImageAspectFlagBits::eDepth, 0, kept_layer, 1},
                     .srcOffset = at,
                     .dstSubresource = {vk::ImageAspectFlagBits::eDepth, 0, layer, 1},
                     .dstOffset = at,
                     .extent = {size.x, size.y, 1}});
}

void ShadowMaps::record(const vk::raii::CommandBuffer& commands) const {
  gpu::record_uploads(commands, {&map_data_});
  if (!due()) return;
  record_kept(commands);
  Layout layout = Layout::eShaderReadOnlyOptimal;
  const auto change_to = [&](Layout next) {
    gpu::transition(commands, maps_.image, layout, next);
    layout = next;
  };
  if (!copies_.empty()) {
    change_to(Layout::eTransferDstOptimal);
    commands.copyImage(*kept_->image.image, Layout::eTransferSrcOptimal, *maps_.image.image, layout, copies_);
  }
  change_to(Layout::eDepthAttachmentOptimal);
  for (std::size_t pass = kept_passes_; pass < passes_.size(); ++pass)
    record_pass(commands, pass, *maps_.pairs[passes_[pass].pair]);
  change_to(Layout::eShaderReadOnlyOptimal);
}

void ShadowMaps::record_kept(const vk::raii::CommandBuffer& commands) const {
  if (kept_passes_ == 0) return;
  gpu::transition(commands, kept_->image, Layout::eTransferSrcOptimal, Layout::eDepthAttachmentOptimal);
  for (std::size_t pass = 0; pass < kept_passes_; ++pass)
    record_pass(commands, pass, *kept_->pairs[layers_.kept_pair[passes_[pass].pair].value()]);
  gpu::transition(commands, kept_->image, Layout::eDepthAttachmentOptimal, Layout::eTransferSrcOptimal);
}

/// Clears the drawn layers, except where moving instances are drawn over what is there.
void ShadowMaps::record_pass(const vk::raii::CommandBuffer& commands, std::size_t pass,
                             vk::ImageView pair) const {
  const vk::Rect2D area{.extent = {settings_.side_px, settings_.side_px}};
  std::vector<vk::ClearRect> single;
  for (std::uint32_t layer = 0; layer < 2; ++layer) {
    const Casters casters = passes_[pass].casters[layer];
    if (casters == Casters::All || casters == Casters::Fixed) single.push_back({area, layer, 1});
  }
  vk::RenderingAttachmentInfo depth = cleared(pair, Layout::eDepthAttachmentOptimal);
  if (single.size() == 2)
    single.clear();
  else
    depth.loadOp = vk::AttachmentLoadOp::eLoad;
  pass_.record(commands, maps_.image.spec.size, {}, depth, pass, single);
}

}  // namespace farshade
