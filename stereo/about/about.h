/// About: what --version prints.
#pragma once

#include <string>
#include <vector>

namespace farshade {

/// Version of the project, build, `protocols` that `program` speaks, and the libraries of the build.
/// `loaded`: libraries whose version the program has found out while it runs. Each of both is a name and a
/// version.
[[nodiscard]] std::string about(const std::string& program, const std::vector<std::string>& protocols,
                                const std::vector<std::string>& loaded);

}  // namespace farshade
