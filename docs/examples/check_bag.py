"""Name the topics of a bag whose types have other definitions here: check_bag.py BAG."""

from importlib.util import find_spec
import json
from pathlib import Path
import sys

import yaml


def share_of(package):
    """Folder of what a package of messages shares, beside lib/python3.X/site-packages."""
    return Path(find_spec(package).origin).parents[4] / 'share' / package


def installed_hash(kind):
    """Hash of a type such as `std_msgs/msg/Bool`; '' if there is no such type here."""
    package, folder, name = kind.split('/')
    if not find_spec(package):
        return ''
    described = share_of(package) / folder / f'{name.partition("_")[0]}.json'
    hashes = json.loads(described.read_text())['type_hashes'] if described.exists() else []
    return {each['type_name']: each['hash_string'] for each in hashes}.get(kind, '')


def differences(bag):
    """Types of topics in a bag whose definition is not the installed one, by topic."""
    described = yaml.safe_load((Path(bag) / 'metadata.yaml').read_text())
    topics = described['rosbag2_bagfile_information']['topics_with_message_count']
    return {
        topic['name']: topic['type']
        for topic in (each['topic_metadata'] for each in topics)
        if topic['type_description_hash'] != installed_hash(topic['type'])
    }


if __name__ == '__main__':
    different = differences(sys.argv[1])
    for topic, kind in different.items():
        print(f'{topic}: the definition of {kind} is not that in the bag')
    sys.exit(bool(different))
