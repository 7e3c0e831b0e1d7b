-- The engine: what turns the tables above into a tree. No wire layout stands here.

local proto = Proto("magician", "Dobot Magician")
proto.prefs.port = Pref.uint("UDP and TCP port of the arm", 8899, "The port that an arm listens on: its side is the arm's")

local DISCOVERY_PORT = 48899
local HEADER = 0xAA
local SHORTEST, LONGEST = 2, 250 -- Len
local UNANSWERED = 64            -- requests that wait for their reply, a link

-- Fields ------------------------------------------------------------------------------------------------------------

local common = {
    len = ProtoField.uint8("magician.len", "Len", base.DEC, nil, nil, "Bytes of id, Ctrl and parameters"),
    id = ProtoField.uint8("magician.id", "Id", base.DEC, nil, nil, "Id of the command"),
    ctrl = ProtoField.uint8("magician.ctrl", "Ctrl", base.HEX, nil, nil, "Control byte"),
    write = ProtoField.bool("magician.ctrl.write", "rw", 8, { "set", "get" }, 0x01),
    queued = ProtoField.bool("magician.ctrl.queued", "isQueued", 8, { "queued", "at once" }, 0x02),
    error = ProtoField.bool("magician.ctrl.error", "Error", 8, { "refused", "no" }, 0x04),
    destination = ProtoField.uint8("magician.ctrl.destination", "Destination", base.DEC, nil, 0x30),
    slave = ProtoField.uint8("magician.ctrl.slave", "Slave", base.DEC, nil, 0xC0),
    command = ProtoField.string("magician.command", "Command", base.UNICODE, "The command's name, with Get or Set"),
    direction = ProtoField.string("magician.direction", "Direction", base.UNICODE, "request or reply"),
    params = ProtoField.bytes("magician.params", "Parameters", base.SPACE, "Parameters of an unknown form"),
    checksum = ProtoField.uint8("magician.checksum", "Checksum", base.HEX),
    good = ProtoField.bool("magician.checksum.good", "Checksum is right"),
    damaged = ProtoField.bytes("magician.damaged", "Damaged frame", base.SPACE, "What looks like a frame and is none"),
    noise = ProtoField.bytes("magician.noise", "Foreign bytes", base.SPACE, "Bytes that belong to no frame"),
    alarm = ProtoField.uint8("magician.alarm", "Alarm", base.HEX, ALARMS, nil, "An alarm that stands"),
    note = ProtoField.string("magician.note", "Note", base.UNICODE, "What a lenient reader let pass"),
    reply_to = ProtoField.framenum("magician.reply_to", "Reply to", base.NONE, frametype.RESPONSE),
    reply_in = ProtoField.framenum("magician.reply_in", "Reply in", base.NONE, frametype.REQUEST),
    time = ProtoField.relative_time("magician.time", "Time since the request"),
    discovery = ProtoField.string("magician.discovery", "Discovery", base.UNICODE, "How arms are found on a network"),
}

local MAKE = {
    u8 = ProtoField.uint8, u16 = ProtoField.uint16, u32 = ProtoField.uint32, u64 = ProtoField.uint64,
    i32 = ProtoField.int32, flag = ProtoField.uint8,
}
local SIZE = { u8 = 1, u16 = 2, u32 = 4, u64 = 8, i32 = 4, f32 = 4, flag = 1, enum = 1 }

local known = {}    -- ProtoFields by filter name
local registered = {} -- the same as a list

local function keep(abbr, field)
    known[abbr] = field
    registered[#registered + 1] = field
end

local function make(abbr, field)
    local name, kind, doc = field.name, field.kind, field.doc
    if kind == "f32" then
        keep(abbr, ProtoField.float(abbr, name, doc))
    elseif kind == "enum" then
        keep(abbr, ProtoField.uint8(abbr, name, base.DEC, ENUMS[field.enum], nil, doc))
    elseif kind == "text" then
        keep(abbr, ProtoField.string(abbr, name, base.UNICODE, doc))
    elseif kind == "bytes" or kind == "alarms" then
        keep(abbr, ProtoField.bytes(abbr, name, base.SPACE, doc))
    elseif kind == "outputs" then
        keep(abbr, ProtoField.bytes(abbr, name, base.SPACE, doc))
        keep(abbr .. ".ratio", ProtoField.uint8(abbr .. ".ratio", "ratio", base.DEC, nil, nil, "Share of the move, percent"))
        keep(abbr .. ".address", ProtoField.uint16(abbr .. ".address", "address", base.DEC, nil, nil, "EIO address"))
        keep(abbr .. ".level", ProtoField.uint8(abbr .. ".level", "level", base.DEC, nil, nil, "Level to set"))
    else
        keep(abbr, MAKE[kind](abbr, name, base.DEC, nil, nil, doc))
    end
end

for _, field in pairs(common) do registered[#registered + 1] = field end
for _, layout in pairs(LAYOUTS) do
    for _, field in ipairs(layout.fields) do
        field.abbr = "magician." .. layout.prefix .. field.name
        if not known[field.abbr] then make(field.abbr, field) end
    end
end
proto.fields = registered

local expert_of = {
    checksum = ProtoExpert.new("magician.expert.checksum", "The checksum is wrong", expert.group.CHECKSUM, expert.severity.ERROR),
    length = ProtoExpert.new("magician.expert.length", "The length fits no form", expert.group.MALFORMED, expert.severity.ERROR),
    truncated = ProtoExpert.new("magician.expert.truncated", "The frame is not whole", expert.group.MALFORMED, expert.severity.WARN),
    unknown = ProtoExpert.new("magician.expert.unknown", "No command has this id", expert.group.UNDECODED, expert.severity.WARN),
    noise = ProtoExpert.new("magician.expert.noise", "Bytes that belong to no frame", expert.group.UNDECODED, expert.severity.NOTE),
    note = ProtoExpert.new("magician.expert.note", "A lenient reader let something pass", expert.group.PROTOCOL, expert.severity.NOTE),
    refused = ProtoExpert.new("magician.expert.refused", "The controller refused the command", expert.group.RESPONSE_CODE, expert.severity.WARN),
    alarm = ProtoExpert.new("magician.expert.alarm", "An alarm stands", expert.group.RESPONSE_CODE, expert.severity.NOTE),
}
local experts = {}
for _, item in pairs(expert_of) do experts[#experts + 1] = item end
proto.experts = experts

-- Parameters --------------------------------------------------------------------------------------------------------

-- How a number of parameter bytes fits a layout; nil if it does not.
local function fit_of(layout, params)
    local count, found = #params, nil
    for _, fit in ipairs(layout.fits) do
        if count >= fit.from and count <= fit.to then found = fit end
    end
    local last = layout.fields[#layout.fields]
    if not found or not last then return found end
    local rest = count - layout.head
    if last.kind == "alarms" and rest < 1 then return nil end
    if last.kind == "outputs" then
        local counted = rest % 4 == 1 and params:byte(layout.head + 1) == (rest - 1) / 4
        if rest % 4 ~= 0 and not counted then return nil end
    end
    return found
end

local function unit_text(unit)
    if unit == "" then return "" end
    if unit:find("[,;]") then return " (" .. unit .. ")" end
    return " " .. unit
end

-- One number: adds it, and gives it as text.
local function add_number(tree, field, range, place)
    local item = tree:add_le(known[field.abbr], range)
    local kind, text = field.kind, nil
    if kind == "f32" then
        text = string.format("%.6g", range:le_float())
    elseif kind == "i32" then
        text = tostring(range:le_int())
    elseif kind == "u64" then
        text = tostring(range:le_uint64())
    else
        text = tostring(range:le_uint())
    end
    if kind == "enum" then
        text = ENUMS[field.enum][range:uint()] or text
    elseif kind == "flag" then
        item:append_text(range:uint() == 0 and " (off)" or " (on)")
    end
    if place then item:set_text(field.name .. "[" .. place .. "]: " .. text) end
    item:append_text(unit_text(field.unit))
    return text
end

local function add_alarms(tree, field, range)
    local item = tree:add(known[field.abbr], range)
    local names = {}
    for at = 0, range:len() - 1 do
        local byte = range(at, 1):uint()
        for bit = 0, 7 do
            if math.floor(byte / 2 ^ bit) % 2 == 1 then
                local code = at * 8 + bit
                local alarm = item:add(common.alarm, range(at, 1), code)
                names[#names + 1] = (ALARMS[code] or string.format("0x%02X", code)):match("^%w+")
                alarm:add_proto_expert_info(expert_of.alarm, ALARMS[code] or "An alarm without a name")
            end
        end
    end
    return #names > 0 and table.concat(names, ",") or "none"
end

local function add_outputs(tree, field, range, notes)
    local count, start, texts = range:len(), 0, {}
    local item = tree:add(known[field.abbr], range)
    if count % 4 == 1 then
        start = 1
        notes[#notes + 1] = NOTES.counted
    end
    for at = start, count - 4, 4 do
        local ratio, address, level = range(at, 1), range(at + 1, 2), range(at + 3, 1)
        item:add(known[field.abbr .. ".ratio"], ratio)
        item:add_le(known[field.abbr .. ".address"], address)
        item:add(known[field.abbr .. ".level"], level)
        texts[#texts + 1] = ratio:uint() .. ":" .. address:le_uint() .. ":" .. level:uint()
    end
    return table.concat(texts, ",")
end

-- Whether a speed is the bits of a float: no motor turns as fast as the number says.
local function is_float(range)
    local number, float = range:le_int(), range:le_float()
    return math.abs(number) > 2 ^ 24 and float == float and math.abs(float) ~= math.huge
end

-- A field that takes the rest of the frame.
local function add_rest(tree, field, range, pinfo, notes)
    if field.kind == "alarms" then return add_alarms(tree, field, range(0, math.min(range:len(), 32))) end
    if field.kind == "outputs" then return add_outputs(tree, field, range, notes) end
    if field.kind == "bytes" then
        tree:add(known[field.abbr], range)
        return range:bytes():tohex()
    end
    local length = range:raw():find("\0", 1, true)
    length = length and length - 1 or range:len()
    if length == 0 then
        tree:add(known[field.abbr], range, "")
        return '""'
    end
    local whole = range(0, length)
    tree:add_packet_field(known[field.abbr], whole, ENC_UTF_8 + ENC_STRING)
    -- range:string() cuts what is no UTF-8 in the middle of a letter, in some versions.
    local text = whole:raw()
    if whole:string(ENC_UTF_8) ~= text then text = text:gsub("[\128-\255]", "?") end
    return '"' .. text:gsub("%c", ".") .. '"'
end

-- The parameters of a frame, `range` (nil for none); adds them and gives them as text.
local function add_params(tree, layout, fit, range, pinfo, notes)
    local texts, at = {}, fit.skip or 0
    local count = range and range:len() or 0
    local function say(field, text) texts[#texts + 1] = (field.short or field.name) .. "=" .. text end
    for _, field in ipairs(layout.fields) do
        local size = SIZE[field.kind]
        if fit.bytes then
            if at >= count then break end
            local value = range(at, 1):uint()
            tree:add(known[field.abbr], range(at, 1), value):append_text(unit_text(field.unit))
            say(field, tostring(value))
            at = at + 1
        elseif not size then
            if at < count then
                say(field, add_rest(tree, field, range(at, count - at), pinfo, notes))
            elseif field.kind == "text" and range then
                tree:add(known[field.abbr], range(count, 0), "")
                say(field, '""')
            elseif field.kind == "text" then
                tree:add(known[field.abbr], "")
                say(field, '""')
            end
            at = count
        else
            local items = {}
            for item = 1, field.count or 1 do
                if at + size > count then break end
                items[item] = add_number(tree, field, range(at, size), field.count and item - 1)
                at = at + size
            end
            if field.kind == "i32" and at >= 4 and #items == 1 and is_float(range(at - 4, 4)) then
                notes[#notes + 1] = NOTES.float
            end
            if #items > 0 then say(field, table.concat(items, ",")) end
            if #items < (field.count or 1) then break end
        end
    end
    return table.concat(texts, " ")
end

-- Requests and their replies ----------------------------------------------------------------------------------------

local waiting, answers, questions = {}, {}, {}

function proto.init()
    waiting, answers, questions = {}, {}, {}
end

-- Remembers a request, or finds that of a reply: the oldest with the same id and Ctrl.
local function match(link, key, pinfo, id, ctrl, request)
    if pinfo.visited then return end
    local queue = waiting[link] or {}
    waiting[link] = queue
    local form = id .. ":" .. (ctrl - math.floor(ctrl / 4) % 2 * 4)
    if request then
        if #queue >= UNANSWERED then table.remove(queue, 1) end
        queue[#queue + 1] = { form = form, key = key, number = pinfo.number, time = pinfo.rel_ts }
        return
    end
    for at, asked in ipairs(queue) do
        if asked.form == form then
            answers[key] = { number = asked.number, time = pinfo.rel_ts - asked.time }
            questions[asked.key] = pinfo.number
            for _ = 1, at do table.remove(queue, 1) end
            return
        end
    end
end

local function add_match(tree, key)
    local answer, question = answers[key], questions[key]
    if answer then
        tree:add(common.reply_to, answer.number):set_generated()
        local seconds = math.floor(answer.time)
        local nanos = math.floor((answer.time - seconds) * 1e9 + 0.5)
        tree:add(common.time, NSTime.new(seconds, nanos)):set_generated()
    end
    if question then tree:add(common.reply_in, question):set_generated() end
end

-- Frames ------------------------------------------------------------------------------------------------------------

-- The form that a frame is in: its plan, who sent it, the layout, how that fits; nil if nothing fits.
local function form_of(row, ctrl, params, direction)
    local plan = row[ctrl % 4]
    local request, reply = fit_of(plan.request, params), fit_of(plan.reply, params)
    if direction == "request" then return plan, direction, plan.request, request end
    if direction == "reply" then return plan, direction, plan.reply, reply end
    local exact = request and not request.note
    if exact and reply and not reply.note then return plan, "request", plan.request, request, NOTES.both end
    if exact or request and not (reply and not reply.note) then return plan, "request", plan.request, request end
    if reply then return plan, "reply", plan.reply, reply end
    return plan, nil, plan.request, nil
end

local function add_ctrl(tree, range)
    local item = tree:add(common.ctrl, range)
    for _, name in ipairs({ "write", "queued", "error", "destination", "slave" }) do
        item:add(common[name], range)
    end
end

local function add_note(tree, text)
    tree:add(common.note, text):set_generated():add_proto_expert_info(expert_of.note, text)
end

-- A whole frame whose checksum is right.
local function add_frame(root, range, pinfo, link, place)
    local bytes = range:raw()
    local id, ctrl = bytes:byte(4), bytes:byte(5)
    local row, params = ROWS[id], bytes:sub(6, -2)
    local tree = root:add(proto, range)
    tree:add(common.len, range(2, 1))
    tree:add(common.id, range(3, 1)):append_text(row and " (" .. row.name .. ")" or "")
    add_ctrl(tree, range(4, 1))
    local body = #params > 0 and range(5, #params) or nil
    local title, notes, wrong = "Unknown command " .. id, {}, nil
    if not row then
        wrong = "unknown"
    else
        local plan, direction, layout, fit, both = form_of(row, ctrl, params, link.direction)
        title = plan.name
        tree:add(common.command, range(3, 2), plan.name)
        if direction then
            tree:add(common.direction, direction):set_generated()
            title = title .. " " .. direction
        end
        if ctrl % 4 >= 2 then title = title .. " queued" end
        if fit then
            local values = add_params(tree, layout, fit, body, pinfo, notes)
            if values ~= "" then title = title .. " " .. values end
            notes[#notes + 1] = fit.note
            for _, note in ipairs(plan.notes) do notes[#notes + 1] = note end
            if math.floor(ctrl / 4) % 2 == 1 then
                notes[#notes + 1] = NOTES.error
                tree:add_proto_expert_info(expert_of.refused)
            end
            if ctrl >= 8 then notes[#notes + 1] = NOTES.destination end
            notes[#notes + 1] = both
            local key = pinfo.number .. ":" .. place
            match(link.name, key, pinfo, id, ctrl, direction == "request")
            add_match(tree, key)
        else
            wrong = "length"
        end
    end
    if wrong then
        if body then tree:add(common.params, body) end
        tree:add_proto_expert_info(expert_of[wrong])
        title = title .. (wrong == "length" and " (its length fits no form)" or "")
    end
    tree:add(common.checksum, range(#bytes - 1, 1)):append_text(" (right)")
    tree:add(common.good, range(#bytes - 1, 1), true):set_generated()
    for _, note in ipairs(notes) do add_note(tree, note) end
    tree:set_text("Dobot Magician, " .. title)
    return title
end

-- What begins as a frame and is none.
local function add_damaged(root, range, reason)
    local count = range:len()
    local tree = root:add(proto, range)
    tree:add(common.damaged, range)
    if count > 2 then tree:add(common.len, range(2, 1)) end
    local title = "Damaged frame"
    if reason == "checksum" then
        local sum, bytes = 0, range:raw()
        for at = 4, count - 1 do sum = sum + bytes:byte(at) end
        local row, found, wanted = ROWS[bytes:byte(4)], bytes:byte(count), -sum % 256
        tree:add(common.id, range(3, 1)):append_text(row and " (" .. row.name .. ")" or "")
        add_ctrl(tree, range(4, 1))
        if count > 6 then tree:add(common.params, range(5, count - 6)) end
        tree:add(common.checksum, range(count - 1, 1)):append_text(string.format(" (the bytes call for 0x%02x)", wanted))
        tree:add(common.good, range(count - 1, 1), false):set_generated()
        title = string.format("%s: checksum is 0x%02x, the bytes call for 0x%02x", title, found, wanted)
    elseif reason == "length" then
        title = string.format("%s: Len is %d, a frame has 2 to 250", title, range(2, 1):uint())
    else
        title = title .. ": it is not whole"
    end
    tree:add_proto_expert_info(expert_of[reason], title)
    tree:set_text("Dobot Magician, " .. title)
    return title
end

local function add_noise(root, range)
    local count = range:len()
    local tree = root:add(proto, range)
    tree:add(common.noise, range):add_proto_expert_info(expert_of.noise)
    local text = range(0, math.min(count, 32)):raw():gsub("[^\32-\126]", ".")
    local title = string.format("%d foreign byte%s: %s%s", count, count == 1 and "" or "s", text, count > 32 and "..." or "")
    tree:set_text("Dobot Magician, " .. title)
    return title
end

-- What stands at a position (from 1): "frame", "noise", "more" or the reason why it is no frame; and its bytes. For
-- "more" it is how many bytes a look needs.
local function judge(bytes, at)
    local left = #bytes - at + 1
    local first, second, len = bytes:byte(at, at + 2)
    if first ~= HEADER or second and second ~= HEADER then
        local next = at + 1
        while next <= #bytes do
            next = bytes:find("\xAA", next, true) or #bytes + 1
            local after = bytes:byte(next + 1)
            if next > #bytes or not after or after == HEADER then break end
            next = next + 1
        end
        return "noise", math.min(next, #bytes + 1) - at
    end
    if left < 3 then return "more", left + 1 end
    if len < SHORTEST or len > LONGEST then return "length", 3 end
    if left < len + 4 then return "more", len + 4 end
    local sum = 0
    for place = at + 3, at + 3 + len do sum = sum + bytes:byte(place) end
    return sum % 256 == 0 and "frame" or "checksum", len + 4
end

-- Dissects bytes that passed on a link. A stream goes on in the next packet, a datagram does not.
local function dissect(tvb, pinfo, root, link)
    local bytes, titles = tvb:raw(), {}
    local at, shown = 1, 1 -- up to `shown` a damaged frame has shown the bytes already
    while at <= #bytes do
        local kind, count = judge(bytes, at)
        if kind == "more" then
            local left = #bytes - at + 1
            if link.stream and pinfo.can_desegment > 0 then
                pinfo.desegment_offset = at - 1
                pinfo.desegment_len = left < 3 and DESEGMENT_ONE_MORE_SEGMENT or count - left
                break
            end
            kind, count = left == 1 and "noise" or "truncated", left
        end
        if kind == "frame" then
            titles[#titles + 1] = add_frame(root, tvb:range(at - 1, count), pinfo, link, at)
            at, shown = at + count, at + count
        elseif kind == "noise" then
            local from = math.max(at, shown)
            if from < at + count then
                titles[#titles + 1] = add_noise(root, tvb:range(from - 1, at + count - from))
            end
            at = at + count
        else
            if at + count > shown then
                titles[#titles + 1] = add_damaged(root, tvb:range(at - 1, count), kind)
                shown = at + count
            end
            at = at + 1
        end
    end
    pinfo.cols.protocol = "Magician"
    if #titles > 0 then
        pinfo.cols.info:set(table.concat(titles, "; "))
        pinfo.cols.info:fence()
    end
end

-- Ways in -----------------------------------------------------------------------------------------------------------

local interface = Field.new("frame.interface_id")

-- Who sent the bytes, by the port that belongs to the arm; nil if neither side has it.
local function by_port(pinfo)
    local port = proto.prefs.port
    local from, to = pinfo.src_port == port, pinfo.dst_port == port
    if from == to then return nil end
    return from and "reply" or "request"
end

local function ends(pinfo)
    local one = tostring(pinfo.src) .. ":" .. pinfo.src_port
    local other = tostring(pinfo.dst) .. ":" .. pinfo.dst_port
    return one < other and one .. " " .. other or other .. " " .. one
end

function proto.dissector(tvb, pinfo, root)
    if tvb:len() == 0 then return 0 end
    if pinfo.port_type == 3 and (pinfo.src_port == DISCOVERY_PORT or pinfo.dst_port == DISCOVERY_PORT) then
        local text = tvb():string(ENC_UTF_8)
        root:add(proto, tvb()):add(common.discovery, tvb(), text)
        pinfo.cols.protocol = "Magician"
        pinfo.cols.info = "Discovery: " .. text
    elseif pinfo.port_type == 2 or pinfo.port_type == 3 then
        local stream = pinfo.port_type == 2
        dissect(tvb, pinfo, root, { name = ends(pinfo), direction = by_port(pinfo), stream = stream })
    else
        -- A trace: its packets say who sent them, seen from the host.
        local direction = ({ [P2P_DIR_SENT] = "request", [P2P_DIR_RECV] = "reply" })[pinfo.p2p_dir]
        if direction then
            pinfo.cols.src = direction == "request" and "host" or "arm"
            pinfo.cols.dst = direction == "request" and "arm" or "host"
        end
        local link = interface()
        dissect(tvb, pinfo, root, { name = "link " .. (link and tostring(link) or ""), direction = direction })
    end
    return tvb:len()
end

local ports = { DissectorTable.get("udp.port"), DissectorTable.get("tcp.port") }
local listening = nil

local function listen()
    for _, of in ipairs(ports) do
        if listening then of:remove(listening, proto) end
        of:add(proto.prefs.port, proto)
    end
    listening = proto.prefs.port
end

function proto.prefs_changed()
    if proto.prefs.port ~= listening then listen() end
end

listen()
ports[1]:add(DISCOVERY_PORT, proto)
DissectorTable.get("wtap_encap"):add((wtap_encaps or wtap).USER0, proto)
