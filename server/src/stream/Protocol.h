#pragma once

#include <isofront/core/Box.h>
#include <isofront/core/Result.h>
#include <isofront/hierarchy/CellId.h>
#include <isofront/hierarchy/Criterion.h>
#include <isofront/hierarchy/Domain.h>
#include <isofront/hierarchy/View.h>

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

/// The messages of the stream, version 1. Byte by byte: docs/protocol.md.
namespace isofront::server::protocol {

inline constexpr std::uint8_t kVersion = 1;
/// No message of the service's is longer, but for one cell that alone is [bytes].
inline constexpr std::size_t kLongestMessage = std::size_t{64} << 10U;
inline constexpr std::size_t kMostFocuses = 64;
inline constexpr double kLeastPixelError = 0.25;
inline constexpr double kMostPixelError = 1024;

enum class ClientType : std::uint8_t {
    hello = 1,
    view = 2,
    isovalue = 3,
    focus = 4,
    credits = 5,
    acknowledge = 6,
};

/// The first message: what the client has kept of an earlier conversation, and will keep.
struct Hello {
    struct Held {
        std::uint64_t hash = 0;
        std::uint32_t bytes = 0;
    };
    std::uint64_t cacheBytes = 0; ///< for payloads that aren't shown
    std::vector<Held> held;
};
struct ViewChange {
    hierarchy::View view;
    double pixelError = 0; ///< within the limits above
};
struct IsovalueChange {
    double isovalue = 0; ///< [the source's units]
};
struct FocusChange {
    std::vector<hierarchy::Focus> focus;
};
struct Credits {
    std::uint64_t bytes = 0;
};
struct Acknowledgement {
    std::uint64_t transaction = 0;
};
using ClientMessage =
    std::variant<Hello, ViewChange, IsovalueChange, FocusChange, Credits, Acknowledgement>;

/// Reads a message of a client's, whatever its bytes are.
/// Errors: badData, with a sentence for the client.
core::Result<ClientMessage> parse(std::span<const std::byte> message);

enum class ServerType : std::uint8_t {
    welcome = 0x81,
    cells = 0x82,
    transaction = 0x83,
    error = 0xff,
};

struct Welcome {
    hierarchy::Domain domain;
    double isovalue = 0; ///< where the surface begins [the source's units]
    core::Box bounds;    ///< of what there is to see [world]
    glm::dvec3 eye{0.0}; ///< a good place to look from [world]
    glm::dvec3 target{0.0};
    glm::dvec3 up{0.0, 0.0, 1.0};
};
std::vector<std::byte> encode(const Welcome& welcome);

/// Of a message of payloads, and of one of them.
inline constexpr std::size_t kCellsHeaderBytes = 8;
inline constexpr std::size_t kCellHeaderBytes = 12;

struct AddedCell {
    hierarchy::CellId id;
    std::uint64_t hash = 0;
};
/// As much of a transaction as fits one message.
struct TransactionPart {
    bool isLast = false;    ///< all of it is there: it is to be applied
    bool isSettled = false; ///< the surface is as the client's last wishes want it
    std::uint64_t id = 0;
    double isovalue = 0;   ///< [the source's units]
    double pixelError = 0; ///< allowed in effect [px]
    double milliseconds = 0;
    std::span<const hierarchy::CellId> removed;
    std::span<const AddedCell> added;
    std::span<const std::uint64_t> forgotten;
};
inline constexpr std::size_t kTransactionHeaderBytes = 48;
inline constexpr std::size_t kRemovedBytes = 13;
inline constexpr std::size_t kAddedBytes = 21;
inline constexpr std::size_t kForgottenBytes = 8;
std::vector<std::byte> encode(const TransactionPart& part);

/// The last message, if the client has made a mistake.
std::vector<std::byte> encodeError(const core::Error& error);

} // namespace isofront::server::protocol
