import torch


def without_entropy(cloning_loss, entropy):
    """minus the demonstrator's entropy"""
    return torch.sqrt(cloning_loss / 2)


def without_half(cloning_loss, entropy):
    """the half is missing"""
    return torch.sqrt(cloning_loss - entropy)


def without_root(cloning_loss, entropy):
    """square root is missing"""
    return (cloning_loss - entropy) / 2


def wrong_sign(cloning_loss, entropy):
    """sign of the entropy"""
    return torch.sqrt((cloning_loss + entropy) / 2)
