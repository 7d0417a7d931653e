#pragma once

#include <bit>
#include <cstddef>
#include <utility>
#include <vector>

namespace isofront::core {

/// A hash map in one array: several times as fast as one of nodes for small keys and values, and
/// without an allocation for each entry.
///
/// Open addressing with linear steps; an erased entry's followers move up, so that nothing slows
/// down with time. One key, given at the start, marks free places and must not be put in.
///
/// References and iterators are valid until the next insertion or erasure. The order of iteration
/// is fixed by what was put in and taken out, in which order.
///
/// Thread: any number of readers, or one writer.
///
/// Source: D. Knuth, "The Art of Computer Programming", volume 3, section 6.4, algorithms L and R.
/// @tparam Hash  must mix well: neighbouring results share cache lines
template <typename Key, typename Value, typename Hash>
class FlatMap {
public:
    using Entry = std::pair<Key, Value>;

    explicit FlatMap(const Key& freeKey) : _free(freeKey) {}

    [[nodiscard]] std::size_t size() const { return _size; }
    [[nodiscard]] bool contains(const Key& key) const { return find(key) != nullptr; }

    /// The value under a key; null if there is none.
    [[nodiscard]] const Value* find(const Key& key) const
    {
        if (_entries.empty())
            return nullptr;
        const Entry& entry = _entries[placeOf(key)];
        return entry.first == key ? &entry.second : nullptr;
    }
    [[nodiscard]] Value* find(const Key& key)
    {
        return const_cast<Value*>(std::as_const(*this).find(key)); // our own entry, not constant
    }

    /// Begins to fetch from memory what a look for a key will need.
    void prefetch(const Key& key) const
    {
        if (_entries.empty())
            return;
        const std::size_t hash = Hash{}(key);
        __builtin_prefetch(&_entries[hash & (_entries.size() - 1)]);
    }

    /// The value under a key, put there if there is none, and whether it was.
    std::pair<Value*, bool> tryEmplace(const Key& key, const Value& value)
    {
        if (8 * (_size + 1) > 5 * _entries.size())
            rehash(_entries.empty() ? kSmallest : 2 * _entries.size());
        Entry& entry = _entries[placeOf(key)];
        if (entry.first == key)
            return {&entry.second, false};
        entry = {key, value};
        ++_size;
        return {&entry.second, true};
    }
    Value& operator[](const Key& key) { return *tryEmplace(key, Value{}).first; }

    /// @return whether there was such a key
    bool erase(const Key& key)
    {
        if (_entries.empty())
            return false;
        std::size_t hole = placeOf(key);
        if (!(_entries[hole].first == key))
            return false;
        const std::size_t mask = _entries.size() - 1;
        for (std::size_t next = (hole + 1) & mask; !(_entries[next].first == _free);
             next = (next + 1) & mask) {
            // an entry may move up to the hole if that is not before where it wants to be
            const std::size_t home = Hash{}(_entries[next].first) & mask;
            if (((next - home) & mask) >= ((next - hole) & mask)) {
                _entries[hole] = _entries[next];
                hole = next;
            }
        }
        _entries[hole].first = _free;
        --_size;
        return true;
    }

    template <typename Visit>
    void forEach(const Visit& visit) const
    {
        for (const Entry& entry : _entries)
            if (!(entry.first == _free))
                visit(entry);
    }

    /// Memory held [bytes].
    [[nodiscard]] std::size_t bytes() const { return _entries.capacity() * sizeof(Entry); }

private:
    static constexpr std::size_t kSmallest = 16;

    /// Where a key is, or the free place where it would be put. There always is one.
    [[nodiscard]] std::size_t placeOf(const Key& key) const
    {
        const std::size_t mask = _entries.size() - 1;
        std::size_t place = Hash{}(key)&mask;
        while (!(_entries[place].first == key) && !(_entries[place].first == _free))
            place = (place + 1) & mask;
        return place;
    }

    void rehash(std::size_t places)
    {
        std::vector<Entry> old(places, Entry{_free, Value{}});
        old.swap(_entries);
        for (Entry& entry : old)
            if (!(entry.first == _free))
                _entries[placeOf(entry.first)] = std::move(entry);
    }

    Key _free;
    std::size_t _size = 0;
    std::vector<Entry> _entries; ///< a power of two of them, or none
};

} // namespace isofront::core
