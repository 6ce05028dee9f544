#include "stereo/scene/gltf_json.h"

#include <limits>
#include <nlohmann/json.hpp>

namespace farshade::gltf {
namespace {

using nlohmann::json;

constexpr std::uint64_t kMaxIndex = (std::uint64_t{1} << 31) - 1, kMaxSize = (std::uint64_t{1} << 53) - 1;
constexpr double kMaxNumber = 1e30;  // fits in a float; products fit in a double

bool is_whole(const json& value, std::uint64_t least, std::uint64_t most) {
  return value.is_number_unsigned() && value.get<std::uint64_t>() >= least &&
         value.get<std::uint64_t>() <= most;
}

bool is_index(const json& value) {
  return is_whole(value, 0, kMaxIndex);
}

bool is_number(const json& value, double least) {
  return value.is_number() && value.get<double>() >= least && value.get<double>() <= kMaxNumber;
}

bool is_text(const json& value) {
  return value.is_string();
}

template <class Test>
bool is_list_of(const json& value, Test test) {
  return value.is_array() && std::all_of(value.begin(), value.end(), test);
}

template <class T>
std::vector<T> list_from(const json* list) {
  return list ? list->get<std::vector<T>>() : std::vector<T>{};
}

}  // namespace

const json* JsonObject::find(std::string_view name) const {
  if (!object_) return nullptr;
  const auto found = object_->find(name);
  return found == object_->end() ? nullptr : &*found;
}

std::string JsonObject::path_of(std::string_view name) const {
  return (path_.empty() ? "" : path_ + ".") + std::string(name);
}

void JsonObject::refuse(std::string what, Fault fault) const {
  if (*verdict_) *verdict_ = fail(fault, std::move(what));
}

/// The member if it is there and fits; otherwise null.
template <class Fits>
const json* JsonObject::member(std::string_view name, Need need, std::string_view expected, Fits fits) const {
  const json* const found = find(name);
  if (!found && object_ && need == Need::Required) refuse(path_of(name) + " is missing");
  if (!found || fits(*found)) return found;
  refuse(path_of(name) + " should be " + std::string(expected));
  return nullptr;
}

std::optional<std::uint64_t> JsonObject::whole(std::string_view name, Need need, std::uint64_t least,
                                               std::uint64_t most) const {
  const std::string expected = "a whole number from " + std::to_string(least) + " to " + std::to_string(most);
  const json* const value =
      member(name, need, expected, [&](const json& v) { return is_whole(v, least, most); });
  return value ? std::optional(value->get<std::uint64_t>()) : std::nullopt;
}

Index JsonObject::index(std::string_view name) const {
  return whole(name, Need::Optional, 0, kMaxIndex);
}

std::uint32_t JsonObject::required_index(std::string_view name) const {
  return static_cast<std::uint32_t>(whole(name, Need::Required, 0, kMaxIndex).value_or(0));
}

std::uint64_t JsonObject::size(std::string_view name) const {
  return whole(name, Need::Optional, 0, kMaxSize).value_or(0);
}

std::uint64_t JsonObject::length(std::string_view name) const {
  return whole(name, Need::Required, 1, kMaxSize).value_or(0);
}

std::optional<double> JsonObject::number(std::string_view name, Sign sign) const {
  const double least = sign == Sign::Any           ? -kMaxNumber
                       : sign == Sign::NotNegative ? 0.0
                                                   : double{std::numeric_limits<float>::min()};
  const std::string_view expected = sign == Sign::Any           ? "a number within +-1e30"
                                    : sign == Sign::NotNegative ? "a number from 0 to 1e30"
                                                                : "a number above 0, up to 1e30";
  const json* const value =
      member(name, Need::Optional, expected, [&](const json& v) { return is_number(v, least); });
  return value ? std::optional(value->get<double>()) : std::nullopt;
}

bool JsonObject::flag(std::string_view name) const {
  const json* const value =
      member(name, Need::Optional, "true or false", [](const json& v) { return v.is_boolean(); });
  return value && value->get<bool>();
}

std::string JsonObject::text(std::string_view name, Need need, const char* otherwise) const {
  const json* const value = member(name, need, "a text", is_text);
  return value ? value->get<std::string>() : otherwise;
}

std::vector<std::string> JsonObject::texts(std::string_view name) const {
  return list_from<std::string>(
      member(name, Need::Optional, "a list of texts", [](const json& v) { return is_list_of(v, is_text); }));
}

std::vector<std::uint32_t> JsonObject::indices(std::string_view name) const {
  return list_from<std::uint32_t>(member(name, Need::Optional, "a list of indices",
                                         [](const json& v) { return is_list_of(v, is_index); }));
}

std::map<std::string, std::uint32_t> JsonObject::required_index_map(std::string_view name) const {
  const json* const map =
      member(name, Need::Required, "an object whose values are indices",
             [](const json& v) { return v.is_object() && std::all_of(v.begin(), v.end(), is_index); });
  return map ? map->get<std::map<std::string, std::uint32_t>>() : std::map<std::string, std::uint32_t>{};
}

std::vector<double> JsonObject::numbers(std::string_view name, std::size_t count) const {
  const std::string expected =
      "a list of " + (count ? std::to_string(count) + " " : "") + "numbers within +-1e30";
  return list_from<double>(member(name, Need::Optional, expected, [&](const json& v) {
    return (count == 0 || v.size() == count) &&
           is_list_of(v, [](const json& n) { return is_number(n, -kMaxNumber); });
  }));
}

JsonObject JsonObject::object(std::string_view name, Need need) const {
  const json* const value = member(name, need, "an object", [](const json& v) { return v.is_object(); });
  return {value, path_of(name), verdict_};
}

std::vector<JsonObject> JsonObject::objects(std::string_view name, Need need) const {
  const json* const list = member(name, need, "a list of objects", [](const json& v) {
    return is_list_of(v, [](const json& item) { return item.is_object(); });
  });
  std::vector<JsonObject> result;
  if (!list) return result;
  result.reserve(list->size());
  for (const json& item : *list)
    result.push_back({&item, path_of(name) + "[" + std::to_string(result.size()) + "]", verdict_});
  return result;
}

}  // namespace farshade::gltf
