/// JsonObject: reads an object of a glTF file's JSON and checks what it reads: a member has the type and the
/// range that the specification gives it. Members that nobody reads are not checked.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "stereo/scene/gltf_document.h"

namespace farshade::gltf {

enum class Need { Optional, Required };
enum class Sign { Any, NotNegative, Positive };

class JsonObject {
 public:
  /// `path` names the object in error messages: "accessors[17]". `verdict` takes the first fault, for example
  /// "accessors[17].count should be a whole number from 1 to 9007199254740991". Keeps both references.
  JsonObject(const nlohmann::json& object, std::string path, Checked& verdict)
      : object_(&object), path_(std::move(path)), verdict_(&verdict) {}

  [[nodiscard]] bool has(std::string_view name) const { return find(name) != nullptr; }

  // Each of these returns the member `name`. A member that is missing or wrong has the default value: none,
  // 0, an empty text, list or object, or `otherwise`.

  /// Below 2^31, so that the sum of two indices fits in 32 bits.
  [[nodiscard]] Index index(std::string_view name) const;
  [[nodiscard]] std::uint32_t required_index(std::string_view name) const;
  /// At most 2^53, so that a double holds every such number exactly.
  [[nodiscard]] std::uint64_t size(std::string_view name) const;
  /// Required, and at least 1.
  [[nodiscard]] std::uint64_t length(std::string_view name) const;
  [[nodiscard]] std::optional<double> number(std::string_view name, Sign sign = Sign::Any) const;
  [[nodiscard]] bool flag(std::string_view name) const;
  [[nodiscard]] std::string text(std::string_view name, Need need = Need::Optional,
                                 const char* otherwise = "") const;
  [[nodiscard]] std::vector<std::string> texts(std::string_view name) const;
  [[nodiscard]] std::vector<std::uint32_t> indices(std::string_view name) const;
  [[nodiscard]] std::map<std::string, std::uint32_t> required_index_map(std::string_view name) const;
  /// `count` numbers; 0: any number of them.
  [[nodiscard]] std::vector<double> numbers(std::string_view name, std::size_t count = 0) const;
  template <class Vector>
  [[nodiscard]] std::optional<Vector> vector(std::string_view name) const {
    const std::vector<double> values = numbers(name, std::size_t{Vector::length()});
    if (values.empty()) return std::nullopt;
    Vector result{};
    for (int i = 0; i < Vector::length(); ++i) result[i] = values[static_cast<std::size_t>(i)];
    return result;
  }

  /// False if the object is missing. Then none of its members is required.
  [[nodiscard]] explicit operator bool() const { return object_ != nullptr; }
  [[nodiscard]] JsonObject object(std::string_view name, Need need = Need::Optional) const;
  [[nodiscard]] std::vector<JsonObject> objects(std::string_view name, Need need = Need::Optional) const;
  /// The object `extensions.name`.
  [[nodiscard]] JsonObject extension(std::string_view name) const {
    return object("extensions").object(name);
  }

  /// Makes `what` the verdict, unless there is an earlier fault.
  void refuse(std::string what, Fault fault = Fault::Malformed) const;

 private:
  JsonObject(const nlohmann::json* object, std::string path, Checked* verdict)
      : object_(object), path_(std::move(path)), verdict_(verdict) {}
  [[nodiscard]] const nlohmann::json* find(std::string_view name) const;
  [[nodiscard]] std::string path_of(std::string_view name) const;
  template <class Fits>
  const nlohmann::json* member(std::string_view name, Need need, std::string_view expected, Fits fits) const;
  std::optional<std::uint64_t> whole(std::string_view name, Need need, std::uint64_t least,
                                     std::uint64_t most) const;

  const nlohmann::json* object_;  ///< null: the object is missing
  std::string path_;
  Checked* verdict_;
};

}  // namespace farshade::gltf
