"""What PX4's tests look for in what they hear."""


def acks(heard, pick):
    return [(ack.command, ack.result) for ack in pick(heard, "COMMAND_ACK")]


def heartbeat_mode(heard, pick):
    beat = pick(heard, "HEARTBEAT")[-1]
    return beat.custom_mode >> 16 & 0xFF, beat.custom_mode >> 24
