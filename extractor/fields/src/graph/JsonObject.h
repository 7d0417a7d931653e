#pragma once

#include "graph/JsonText.h"

#include <string>
#include <vector>

namespace isofront::fields::graph {

/// A JSON object of which every key has to be asked for: what is left in the end is unknown.
class JsonObject {
public:
    /// @param what  names the object in errors
    JsonObject(const Json& value, std::string what);

    [[nodiscard]] const std::string& what() const { return _what; }
    [[noreturn]] void fail(const std::string& why) const;

    const Json& required(const std::string& key);
    const Json* optional(const std::string& key);

    std::string text(const std::string& key);
    /// A text to show: one line that isn't long.
    std::string line(const std::string& key);
    /// Which of the words it is; `otherwise` if it isn't there.
    std::size_t
    choice(const std::string& key, const std::vector<std::string>& words, std::size_t otherwise);
    bool flag(const std::string& key, bool otherwise);
    double number(const std::string& key, double least, double most);
    double number(const std::string& key, double least, double most, double otherwise);
    double whole(const std::string& key, double least, double most);
    double whole(const std::string& key, double least, double most, double otherwise);
    /// A list of so many numbers, of magnitudes up to `most`.
    std::vector<double> numbers(const std::string& key, std::size_t count, double most);

    /// A value as a number within limits.
    [[nodiscard]] double
    checked(const Json& value, const std::string& key, double least, double most) const;

    /// Fails if there is a key that was not asked for.
    void finish() const;

private:
    const Json& _value;
    std::string _what;
    std::vector<std::string> _known;
};

} // namespace isofront::fields::graph
