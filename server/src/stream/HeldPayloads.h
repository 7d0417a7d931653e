#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

namespace isofront::server {

/// The payloads that a client has, as far as the service is concerned: those of the cells that it
/// shows, and others as long as there is room for them. The service decides what goes and tells
/// the client, so that both know the same at every transaction.
class HeldPayloads {
public:
    /// @param bytes  for payloads that are not shown
    void setCapacity(std::uint64_t bytes) { _capacity = bytes; }

    void insert(std::uint64_t hash, std::size_t bytes)
    {
        if (_held.try_emplace(hash, Held{bytes, 0, _turn}).second)
            _idleBytes += bytes;
    }
    [[nodiscard]] bool contains(std::uint64_t hash) const { return _held.contains(hash); }
    /// Counts a cell that shows it. It is there.
    void show(std::uint64_t hash)
    {
        Held& held = _held.at(hash);
        if (held.shown++ == 0)
            _idleBytes -= held.bytes;
    }
    void hide(std::uint64_t hash)
    {
        Held& held = _held.at(hash);
        held.lastShown = _turn;
        if (--held.shown == 0)
            _idleBytes += held.bytes;
    }

    /// Ends a turn: lets go of what has not been shown for longest, if there is too much, and says
    /// what.
    std::vector<std::uint64_t> endTurn()
    {
        ++_turn;
        std::vector<std::uint64_t> forgotten;
        if (_idleBytes <= _capacity)
            return forgotten;
        std::vector<std::pair<std::uint64_t, std::uint64_t>> idle; // when, what
        for (const auto& [hash, held] : _held)
            if (held.shown == 0)
                idle.emplace_back(held.lastShown, hash);
        std::ranges::sort(idle);
        // some more than must be, so that it isn't done every time
        for (const auto& [when, hash] : idle) {
            if (_idleBytes <= _capacity / 4 * 3)
                break;
            const auto held = _held.find(hash);
            _idleBytes -= held->second.bytes;
            _held.erase(held);
            forgotten.push_back(hash);
        }
        return forgotten;
    }

    /// What knowing them takes here [bytes], about.
    [[nodiscard]] std::size_t bytes() const { return _held.size() * (sizeof(Held) + 40); }

private:
    struct Held {
        std::size_t bytes = 0;
        std::uint32_t shown = 0; ///< by so many cells
        std::uint64_t lastShown = 0;
    };
    std::unordered_map<std::uint64_t, Held> _held;
    std::uint64_t _capacity = 0;
    std::uint64_t _idleBytes = 0;
    std::uint64_t _turn = 0;
};

} // namespace isofront::server
