#include "graph/JsonObject.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace isofront::fields::graph {

namespace {

std::string shown(double value)
{
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    return text;
}

} // namespace

JsonObject::JsonObject(const Json& value, std::string what) : _value(value), _what(std::move(what))
{
    if (!value.is_object())
        fail("it must be an object, in braces");
}

void JsonObject::fail(const std::string& why) const
{
    throw Problem{_what + ": " + why};
}

const Json* JsonObject::optional(const std::string& key)
{
    if (std::find(_known.begin(), _known.end(), key) == _known.end())
        _known.push_back(key);
    const auto found = _value.find(key);
    return found == _value.end() ? nullptr : &*found;
}

const Json& JsonObject::required(const std::string& key)
{
    const Json* value = optional(key);
    if (value == nullptr)
        fail("the key '" + key + "' is missing; add it");
    return *value;
}

std::string JsonObject::text(const std::string& key)
{
    const Json& value = required(key);
    if (!value.is_string())
        fail("'" + key + "' must be a text, in quotes");
    return value.get<std::string>();
}

std::string JsonObject::line(const std::string& key)
{
    constexpr std::size_t kLongest = 1000;
    std::string value = text(key);
    if (value.size() > kLongest)
        fail("'" + key + "' is longer than " + std::to_string(kLongest) + " bytes; shorten it");
    if (std::any_of(value.begin(), value.end(), [](char c) {
            return static_cast<unsigned char>(c) < 0x20U || c == '\x7f';
        }))
        fail("'" + key + "' must be one line without control characters");
    return value;
}

std::size_t JsonObject::choice(
    const std::string& key, const std::vector<std::string>& words, std::size_t otherwise)
{
    if (optional(key) == nullptr)
        return otherwise;
    const std::string word = text(key);
    const auto found = std::find(words.begin(), words.end(), word);
    if (found != words.end())
        return static_cast<std::size_t>(found - words.begin());
    fail("'" + key + "' must be one of " + listed(words) + ", not " + inQuotes(word));
}

bool JsonObject::flag(const std::string& key, bool otherwise)
{
    const Json* value = optional(key);
    if (value == nullptr)
        return otherwise;
    if (!value->is_boolean())
        fail("'" + key + "' must be true or false");
    return value->get<bool>();
}

double
JsonObject::checked(const Json& value, const std::string& key, double least, double most) const
{
    const double number = value.is_number() ? value.get<double>() : std::nan("");
    if (!(number >= least && number <= most))
        fail(
            "'" + key + "' must be a number from " + shown(least) + " to " + shown(most) +
            (value.is_number() ? ", not " + shown(number) : ""));
    return number;
}

double JsonObject::number(const std::string& key, double least, double most)
{
    return checked(required(key), key, least, most);
}

double JsonObject::number(const std::string& key, double least, double most, double otherwise)
{
    return optional(key) == nullptr ? otherwise : number(key, least, most);
}

double JsonObject::whole(const std::string& key, double least, double most)
{
    const double value = number(key, least, most);
    if (value != std::floor(value))
        fail("'" + key + "' must be a whole number, not " + shown(value));
    return value;
}

double JsonObject::whole(const std::string& key, double least, double most, double otherwise)
{
    return optional(key) == nullptr ? otherwise : whole(key, least, most);
}

std::vector<double> JsonObject::numbers(const std::string& key, std::size_t count, double most)
{
    const Json& list = required(key);
    if (!list.is_array() || list.size() != count)
        fail("'" + key + "' must be a list of " + std::to_string(count) + " numbers");
    std::vector<double> all;
    for (const Json& value : list)
        all.push_back(checked(value, key, -most, most));
    return all;
}

void JsonObject::finish() const
{
    for (const auto& item : _value.items()) {
        if (std::find(_known.begin(), _known.end(), item.key()) != _known.end())
            continue;
        fail(
            "there is no key " + inQuotes(item.key()) + suggestion(item.key(), _known) +
            (_known.empty() ? "; remove it" : "; it may have " + listed(_known)));
    }
}

} // namespace isofront::fields::graph
