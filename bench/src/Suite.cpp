#include "isofront/bench/Suite.h"

#include "suites/Suites.h"

#include <algorithm>

namespace isofront::bench {

const std::vector<Suite>& suites()
{
    static const std::vector<Suite> all = {
        {"accuracy",
         "How far is the mesh from the true surface, by triangles and time, against other methods?",
         runAccuracy},
    };
    return all;
}

core::Result<std::vector<Suite>> suitesNamed(const std::vector<std::string>& names)
{
    if (names.empty())
        return suites();
    std::string known;
    for (const Suite& suite : suites())
        known += (known.empty() ? "" : ", ") + suite.name;
    for (const std::string& name : names)
        if (std::ranges::find(suites(), name, &Suite::name) == suites().end())
            return core::failure(
                core::ErrorCode::usage, "unknown suite '" + name + "': there are " + known);
    std::vector<Suite> chosen;
    std::ranges::copy_if(suites(), std::back_inserter(chosen), [&](const Suite& suite) {
        return std::ranges::find(names, suite.name) != names.end();
    });
    return chosen;
}

} // namespace isofront::bench
